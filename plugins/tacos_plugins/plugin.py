"""Lists the default components. Light: names code by string and imports none of it."""

from __future__ import annotations

from tacos_framework.components import Component
from tacos_framework.environment import Finding
from tacos_framework.hookspecs import hookimpl


@hookimpl
def tacos_components() -> list[Component]:
    """The default plugins."""
    return [
        Component(
            "scene",
            "indoor",
            "tacos_plugins.scenes.indoor.scene:IndoorScene",
            summary="Procedural furnished rooms with thresholds at the doors and an agent walking through.",
        ),
        Component(
            "rig",
            "monocular",
            "tacos_plugins.rigs.monocular:MonocularRig",
            summary="One camera, pitched up or down, with a sensor from a catalog.",
        ),
        Component(
            "rig",
            "stereo",
            "tacos_plugins.rigs.stereo:StereoRig",
            summary="Two parallel cameras a baseline apart.",
        ),
        Component(
            "renderer",
            "moderngl",
            "tacos_plugins.renderers.moderngl.renderer:ModernglRenderer",
            summary="Headless OpenGL rasterizer: physically based light, exact depth and ids.",
        ),
        Component(
            "renderer",
            "analytic",
            "tacos_plugins.renderers.analytic:AnalyticRenderer",
            summary="Small ray caster without OpenGL, for tests and machines without it.",
        ),
        Component(
            "effect",
            "vignetting",
            "tacos_plugins.effects.vignetting:Vignetting",
            summary="Light that falls off towards the corners: an even polynomial of the radius.",
        ),
        Component(
            "sensor",
            "affine-noise",
            "tacos_plugins.sensors.affine_noise:AffineNoise",
            summary="Photon and thermal noise, scaled by gain and pixel area.",
        ),
        Component(
            "task",
            "orb-features",
            "tacos_plugins.tasks.orb_features:OrbFeatures",
            summary="ORB features matched over consecutive frames; counts RANSAC inliers.",
        ),
        Component(
            "task",
            "obstacle-visibility",
            "tacos_plugins.tasks.obstacle_visibility:ObstacleVisibility",
            summary="Share of thresholds on the path that were seen before they were stepped on.",
        ),
        Component(
            "optimizer",
            "genetic",
            "tacos_plugins.optimizers.genetic:Genetic",
            summary="The paper's genetic algorithm: elites, uniform crossover, factor and offset mutation.",
        ),
        Component(
            "optimizer",
            "random",
            "tacos_plugins.optimizers.random_search:RandomSearch",
            summary="Independent uniform draws: the baseline any search must beat.",
        ),
        Component(
            "executor",
            "local",
            "tacos_plugins.executors.local:LocalExecutor",
            summary="Evaluates candidates one after another in this process.",
        ),
        Component(
            "executor",
            "process",
            "tacos_plugins.executors.process:ProcessExecutor",
            summary="Evaluates candidates in spawned processes, one GL context each.",
        ),
    ]


@hookimpl
def tacos_doctor() -> list[Finding]:
    """What renders here: a GPU, the CPU, or nothing."""
    from tacos_framework.errors import UserError
    from tacos_plugins.renderers.moderngl.context import describe_gl

    try:
        return [Finding("OpenGL", str(describe_gl()))]
    except UserError as error:
        (fault,) = error.faults
        return [Finding("OpenGL", fault.what, ok=False, remedy=fault.remedy)]
