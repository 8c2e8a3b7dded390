"""Bright squares before a dark ground: something to detect, in milliseconds and without OpenGL."""

from __future__ import annotations

from typing import Any

import numpy as np

from tacos_framework.components import Component
from tacos_framework.hookspecs import hookimpl
from tacos_framework.settings import Settings, setting
from tacos_framework.testing.samples import sample_rig
from tacos_framework.values import (
    Capture,
    Episode,
    Exposure,
    FrameBatch,
    Object,
    Rig,
    Trajectory,
    View,
    World,
)

COLOURS = {"sofa": (20.0, 2.0, 2.0), "bed": (2.0, 2.0, 20.0)}
"""Luminance of the squares of each class [cd/m2]."""
GROUND_CD_M2 = 1.0


@hookimpl
def tacos_components() -> list[Component]:
    return [
        Component("scene", "squares", "toy_detection:SquaresScene", summary="A toy."),
        Component("renderer", "squares", "toy_detection:SquaresRenderer", summary="A toy."),
    ]


class SquaresScene:
    """A world with a square of each class."""

    class Config(Settings):
        frames: int = setting(4, help="Frames of an episode.", ge=1)
        classes: tuple[str, ...] = setting(tuple(COLOURS), help="Classes of the squares.")

    def __init__(self, config: Config):
        self.config = config

    def episode(self, *, rng: np.random.Generator) -> Episode:
        names = self.config.classes
        world = World(
            key=str(rng.integers(2**32)),
            parts=(),
            materials=(),
            objects=(Object("ground", "background"), *(Object(name, name) for name in names)),
            class_names=("background", *names),
        )
        still = Trajectory(np.zeros(1), np.eye(4)[None])
        count = self.config.frames
        return Episode(world, still, np.arange(count) / 10, np.zeros(count, np.int32))


class SquaresRenderer:
    """Paints the squares somewhere else in each frame, wherever the camera looks."""

    class Config(Settings):
        side_px: int = setting(16, help="Edge of the squares.", unit="px")

    def __init__(self, config: Config):
        self.config = config

    def capture(self, episode: Episode, *, rig: Rig, exposure: Exposure) -> Capture:
        side = self.config.side_px
        views = []
        for camera in rig.cameras:
            height, width = camera.height_px, camera.width_px
            light = np.full((len(episode), height, width, 3), GROUND_CD_M2, np.float32)
            ids = np.zeros((len(episode), height, width), np.int32)
            for frame in range(len(episode)):
                place = np.random.default_rng([int(episode.world.key), episode.first_frame + frame])
                for i, thing in enumerate(episode.world.objects[1:], start=1):
                    top, left = place.integers(height - side + 1), place.integers(width - side + 1)
                    square = np.s_[frame, top : top + side, left : left + side]
                    light[square], ids[square] = COLOURS.get(thing.class_name, (9.0, 9.0, 9.0)), i
            poses = np.tile(np.eye(4), (len(episode), 1, 1))
            views.append(View(camera, poses, light, np.ones(ids.shape, np.float32), ids))
        return Capture(episode, tuple(views))


def squares(
    frames: int = 4,
    seed: int = 0,
    *,
    width_px: int = 64,
    height_px: int = 48,
    mono: bool = False,
    **scene: Any,
) -> FrameBatch:
    """Frames of squares at 8 bits, without noise."""
    episode = SquaresScene(SquaresScene.Config(frames=frames, **scene)).episode(
        rng=np.random.default_rng(seed)
    )
    rig = sample_rig(width_px=width_px, height_px=height_px)
    capture = SquaresRenderer(SquaresRenderer.Config()).capture(
        episode, rig=rig, exposure=Exposure(time_s=0.03, f_number=2.0, gain_db=5.0)
    )
    light = capture.views[0].luminance_cd_m2 * 10
    image = np.rint(light.mean(axis=-1, keepdims=True) if mono else light).astype(np.uint8)
    return FrameBatch(capture, (image,))
