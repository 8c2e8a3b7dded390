"""Lists the default components. Light: names code by string and imports none of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from tacos_framework.components import Component
from tacos_framework.environment import Finding
from tacos_framework.hookspecs import hookimpl

SCENES = {
    "indoor": (
        "indoor.scene:IndoorScene",
        "Procedural furnished rooms with thresholds at the doors and an agent walking through.",
    ),
}

RIGS = {
    "monocular": (
        "monocular:MonocularRig",
        "One camera, pitched up or down, with a sensor from a catalog.",
    ),
    "stereo": (
        "stereo:StereoRig",
        "Two parallel cameras a baseline apart.",
    ),
}

RENDERERS = {
    "moderngl": (
        "moderngl.renderer:ModernglRenderer",
        "Headless OpenGL rasterizer: physically based light, exact depth and ids.",
    ),
    "analytic": (
        "analytic:AnalyticRenderer",
        "Small ray caster without OpenGL, for tests and machines without it.",
    ),
}

EFFECTS = {
    "vignetting": (
        "vignetting:Vignetting",
        "Light that falls off towards the corners: an even polynomial of the radius.",
    ),
}

SENSORS = {
    "affine-noise": (
        "affine_noise:AffineNoise",
        "Photon and thermal noise, scaled by gain and pixel area.",
    ),
}

TASKS = {
    "orb-features": (
        "orb_features:OrbFeatures",
        "ORB features matched over consecutive frames; counts RANSAC inliers.",
    ),
    "obstacle-visibility": (
        "obstacle_visibility:ObstacleVisibility",
        "Share of thresholds on the path that were seen before they were stepped on.",
    ),
}

OPTIMIZERS = {
    "genetic": (
        "genetic:Genetic",
        "The paper's genetic algorithm: elites, uniform crossover, factor and offset mutation.",
    ),
    "random": (
        "random_search:RandomSearch",
        "Independent uniform draws: the baseline any search must beat.",
    ),
}

EXECUTORS = {
    "local": (
        "local:LocalExecutor",
        "Evaluates candidates one after another in this process.",
    ),
    "process": (
        "process:ProcessExecutor",
        "Evaluates candidates in spawned processes, one GL context each.",
    ),
}

FAMILIES: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "scene": SCENES,
    "rig": RIGS,
    "renderer": RENDERERS,
    "effect": EFFECTS,
    "sensor": SENSORS,
    "task": TASKS,
    "optimizer": OPTIMIZERS,
    "executor": EXECUTORS,
}
"""Kind -> name -> module and class within the family's folder, summary, and packages it needs."""


@hookimpl
def tacos_components() -> list[Component]:
    """The default plugins."""
    return list(_components())


def _components() -> Iterator[Component]:
    for kind, family in FAMILIES.items():
        for name, (target, summary, *requires) in family.items():
            yield Component(kind, name, f"tacos_plugins.{kind}s.{target}", summary, tuple(requires))


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
