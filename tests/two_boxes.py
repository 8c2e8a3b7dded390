"""A scene of two boxes in a room, for tests that render: a plugin to be registered by hand."""

from __future__ import annotations

import sys

import numpy as np

from tacos_framework.components import Component
from tacos_framework.hookspecs import hookimpl
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Recipe
from tacos_framework.settings import Settings, setting
from tacos_framework.values import Episode, Object, Trajectory, World
from tests.small_worlds import box, matte, pose, room

WALK = ((0.0, -0.3), (0.4, 0.3))
"""Where the agent is at the beginning and after a second, along x and y [m]."""


class TwoBoxes:
    """A cup and a chair before a wall; the agent goes forward and to its left."""

    class Config(Settings):
        frames: int = setting(3, help="Frames.", ge=1)

    def __init__(self, config: Config) -> None:
        self.config = config

    def episode(self, *, rng: np.random.Generator, illumination_lux: float) -> Episode:
        """Always the same world, in even light."""
        parts = [
            *room((-2, -3, 0), (5, 3, 3)),
            *box((2.0, -0.8, 0.6), (2.6, -0.2, 1.6), object_id=1),
            *box((3.0, 0.2, 0.0), (3.8, 1.0, 1.4), object_id=2),
        ]
        lit = tuple(np.full((len(part.vertices_m), 3), illumination_lux, np.float32) for part in parts)
        world = World(
            key="two boxes",
            parts=tuple(parts),
            materials=(matte(0.5),),
            objects=(Object("room", "background"), Object("cup", "cup"), Object("chair", "chair")),
            class_names=("background", "chair", "cup", "dog"),
            indirect_lux=lit,
        )
        ends = np.stack([pose((x, y, 1.2), (1.0, 0.1 * i, 0.0)) for i, (x, y) in enumerate(WALK)])
        times = np.linspace(0.0, 1.0, self.config.frames + 2)[1:-1]
        return Episode(world, Trajectory([0.0, 1.0], ends), times, np.zeros(self.config.frames))


@hookimpl
def tacos_components() -> list[Component]:
    """The scene."""
    return [Component("scene", "two-boxes", "tests.two_boxes:TwoBoxes", summary="Two boxes.")]


def plugins_with_boxes() -> Plugins:
    """The installed plugins and the scene."""
    plugins = Plugins.discover()
    plugins.register(sys.modules[__name__])
    return plugins


SENSOR = {"name": "small", "width_px": 128, "height_px": 96, "pixel_um": 10.0, "full_well_e": 9000.0}


def monocular_recipe(**sections: object) -> Recipe:
    """One camera before the boxes, with a few effects if asked for."""
    return Recipe.model_validate(_RECIPE | sections)


def stereo_recipe(**sections: object) -> Recipe:
    """Two cameras before the boxes."""
    rig = {"use": "rig.stereo", "binning": 2, "sensor": SENSOR}
    design = {"baseline_m": {"between": [0.1, 0.3]}, "hfov_deg": {"between": [70, 90]}}
    return Recipe.model_validate(_RECIPE | {"rig": rig, "design": design} | sections)


_RECIPE = {
    "name": "two boxes",
    "rig": {"use": "rig.monocular", "binning": 2, "sensor": SENSOR},
    "design": {"focal_length_mm": {"between": [0.5, 0.7]}, "pitch_deg": {"between": [-10, 0]}},
    "nodes": {
        "world": {"use": "scene.two-boxes"},
        "capture": {"use": "renderer.analytic", "in": {"episode": "world"}},
        "frames": {"use": "sensor.affine-noise", "in": {"capture": "capture"}},
        "features": {"use": "task.orb-features", "in": {"frames": "frames"}},
    },
    "fitness": [{"score": "features.inliers", "weight": 1}],
    "optimizer": {"use": "optimizer.random", "evaluations": 1},
}
