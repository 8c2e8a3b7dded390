"""Components that cost next to nothing, so that a soak is about the framework; see `soak`."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from tacos_framework.components import Component
from tacos_framework.contracts import Scores, State
from tacos_framework.hookspecs import hookimpl
from tacos_framework.settings import Settings, setting
from tacos_framework.values import Capture, Episode, Exposure, Object, Rig, Trajectory, View, World


@hookimpl
def tacos_components() -> list[Component]:
    """The components."""
    return [
        Component("scene", "soak", "soak_toy:Scene", summary="A light and no things."),
        Component("renderer", "soak", "soak_toy:Renderer", summary="The light alone."),
        Component("task", "soak", "soak_toy:Task", summary="Likes one field of view."),
    ]


class Scene:
    """A light."""

    class Config(Settings):
        """Settings."""

        frames: int = setting(2, help="Frames of an episode.", ge=1)

    def __init__(self, config: Config) -> None:
        self.config = config

    def episode(self, *, rng: np.random.Generator, illumination_lux: float) -> Episode:
        """The agent stands still."""
        world = World(
            key=str(rng.integers(2**32)),
            parts=(),
            materials=(),
            objects=(Object("background", "background"),),
            class_names=("background",),
            ambient_cd_m2=np.full(3, illumination_lux * rng.uniform(0.5, 1.5) / np.pi, np.float32),
        )
        count = self.config.frames
        still = Trajectory(np.array([0.0]), np.eye(4)[None])
        return Episode(world, still, np.arange(count) / 10, np.zeros(count, np.int32))


class Renderer:
    """Sees the light."""

    class Config(Settings):
        """No settings."""

    def __init__(self, config: Config) -> None:
        self.config = config

    def capture(self, episode: Episode, *, rig: Rig, exposure: Exposure) -> Capture:
        """Even pictures."""
        views = []
        for camera in rig.cameras:
            size = (len(episode), camera.height_px, camera.width_px)
            light = np.broadcast_to(episode.world.ambient_cd_m2, (*size, 3))
            poses = np.tile(np.eye(4), (len(episode), 1, 1))
            views.append(View(camera, poses, light, np.full(size, np.inf), np.zeros(size, np.int32)))
        return Capture(episode, tuple(views))


class Task:
    """Scores how near the field of view is to 90 degrees."""

    class Config(Settings):
        """No settings."""

    scores: ClassVar[tuple[str, ...]] = ("closeness",)

    def __init__(self, config: Config) -> None:
        self.config = config

    def begin(self, *, state: State | None) -> Scorer:
        """A scorer of one episode."""
        return Scorer()


class Scorer:
    """Of one episode."""

    def __init__(self) -> None:
        self._seen: list[float] = []

    def update(self, capture: Capture) -> None:
        """See some frames."""
        view = capture.views[0]
        light = float(view.luminance_cd_m2.mean())
        self._seen.append(1 - abs(view.camera.hfov_deg - 90) / 180 + 1e-4 * light)

    def scores(self) -> Scores:
        """What came of it."""
        return {"closeness": float(np.mean(self._seen))}
