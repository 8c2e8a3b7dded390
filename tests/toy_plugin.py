"""A plugin of toys: a whole study in milliseconds, and components that misbehave on purpose."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from tacos_framework.components import Component
from tacos_framework.contracts import Budget, Scores, State
from tacos_framework.errors import CandidateFailed
from tacos_framework.hookspecs import hookimpl
from tacos_framework.settings import Settings, setting
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

_KINDS = {
    "scene.toy": "ToyScene",
    "renderer.toy": "ToyRenderer",
    "sensor.toy": "ToySensor",
    "task.toy-width": "WidthTask",
    "task.toy-learner": "Learner",
    "effect.toy-dim": "Dim",
    "effect.toy-offset": "Offset",
    "effect.toy-invert": "Invert",
    "transform.toy-mean": "Mean",
    "task.toy-level": "Level",
}


@hookimpl
def tacos_components() -> list[Component]:
    return [
        Component(*use.split(".", 1), f"toy_plugin:{name}", summary="A toy.") for use, name in _KINDS.items()
    ]


class ToyScene:
    class Config(Settings):
        frames: int = setting(6, help="Frames of an episode.", ge=1)

    def __init__(self, config: Config):
        self.config = config

    def episode(self, *, rng: np.random.Generator, illumination_lux: float) -> Episode:
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


class ToyRenderer:
    """Sees the ambient light and nothing else."""

    class Config(Settings):
        pass

    def __init__(self, config: Config):
        pass

    def capture(self, episode: Episode, *, rig: Rig, exposure: Exposure) -> Capture:
        views = []
        for camera in rig.cameras:
            size = (len(episode), camera.height_px, camera.width_px)
            light = np.broadcast_to(episode.world.ambient_cd_m2, (*size, 3))
            poses = np.tile(np.eye(4), (len(episode), 1, 1))
            views.append(View(camera, poses, light, np.full(size, np.inf), np.zeros(size, np.int32)))
        return Capture(episode, tuple(views))


class ToySensor:
    class Config(Settings):
        sigma_dn: float = setting(1.0, help="Noise.", unit="DN", ge=0)

    def __init__(self, config: Config):
        self.config = config

    black_level_dn = 0.0
    white_level_dn = 255.0

    def expect(self, light_cd_m2, *, camera, exposure: Exposure):
        return light_cd_m2 * np.float32(10 * exposure.gain)

    def moments(self, samples_dn, *, camera, exposure, photon_scale=1.0):
        return samples_dn, np.full_like(samples_dn, self.config.sigma_dn**2)

    def draw(self, samples_dn, *, camera, exposure, rng, photon_scale=1.0):
        return samples_dn + self.config.sigma_dn * rng.standard_normal(samples_dn.shape, dtype=np.float32)

    def dn_per_electron(self, camera, exposure):
        return None


class WidthTask:
    """Likes cameras of a certain field of view; the noise of the frames wavers its opinion a little."""

    class Config(Settings):
        wanted_deg: float = setting(90.0, help="The best field of view.", unit="deg")
        fail_above_deg: float = setting(360.0, help="Refuses to judge wider cameras.", unit="deg")
        crash_above_deg: float = setting(360.0, help="Has a defect there.", unit="deg")
        die_above_deg: float = setting(360.0, help="Takes its process with it there.", unit="deg")

    scores: ClassVar[tuple[str, ...]] = ("closeness", "brightness")
    margins: ClassVar[Mapping[str, float]] = {"closeness": 0.01}
    begun: ClassVar[int] = 0
    interrupt_at: ClassVar[int | None] = None
    """Acts as Ctrl-C when this many episodes have begun in this process."""

    def __init__(self, config: Config):
        self.config = config

    def begin(self, *, state: State | None) -> WidthScorer:
        WidthTask.begun += 1
        if WidthTask.begun == WidthTask.interrupt_at:
            os.kill(os.getpid(), signal.SIGINT)
        return WidthScorer(self.config)


class WidthScorer:
    def __init__(self, config: WidthTask.Config):
        self._config, self._seen = config, []

    def update(self, frames: FrameBatch) -> None:
        camera = frames.capture.views[0].camera
        if camera.hfov_deg > self._config.crash_above_deg:
            raise ZeroDivisionError("a defect of the toy")
        if camera.hfov_deg > self._config.die_above_deg:
            os.kill(os.getpid(), signal.SIGSEGV)
        if camera.hfov_deg > self._config.fail_above_deg:
            raise CandidateFailed(f"cannot judge {camera.hfov_deg:.0f} deg")
        mean = float(frames.images[0].mean())
        self._seen.append((1 - abs(camera.hfov_deg - self._config.wanted_deg) / 180 + 1e-4 * mean, mean))

    def scores(self) -> Scores:
        closeness, brightness = np.mean(self._seen, axis=0)
        return {"closeness": closeness, "brightness": brightness}


class Learner:
    """Learns the mean brightness of the frames; scores how well it knows it."""

    class Config(Settings):
        pass

    scores: ClassVar[tuple[str, ...]] = ("knowledge",)

    def __init__(self, config: Config):
        pass

    def initial_state(self, *, rng: np.random.Generator) -> State:
        return {"mean": np.array([rng.uniform(0, 1)]), "steps": np.array([0])}

    def fit(
        self, batches: Iterable[FrameBatch], *, state: State, budget: Budget, rng: np.random.Generator
    ) -> State:
        mean, steps = state["mean"].copy(), int(state["steps"][0])
        rate = (budget.settings or {}).get("rate", 0.5)
        for _ in range(budget.epochs):
            for frames in batches:
                mean += rate * (frames.images[0].mean() - mean)
                steps += 1
        return {"mean": mean, "steps": np.array([steps])}

    def begin(self, *, state: State | None) -> LearnerScorer:
        assert state is not None
        return LearnerScorer(state)


class LearnerScorer:
    def __init__(self, state: State):
        self._state, self._errors = state, []

    def update(self, frames: FrameBatch) -> None:
        self._errors.append(abs(float(frames.images[0].mean()) - float(self._state["mean"][0])))

    def scores(self) -> Scores:
        return {"knowledge": -float(np.mean(self._errors))}


class Dim:
    """Takes away a share of the light."""

    class Config(Settings):
        share: float = setting(0.0, help="Share of the light lost.", ge=0, le=1)

    stage = "optics"
    neutral: ClassVar[Mapping[str, Any]] = {"share": 0.0}

    def __init__(self, config: Config):
        self.config = config

    def on_array(self, samples, *, geometry, context, rng):
        return samples * (1 - self.config.share) if self.config.share else samples


class Offset:
    """Adds a pedestal nobody knows of."""

    class Config(Settings):
        offset_dn: float = setting(0.0, help="What is added.", unit="DN")

    stage = "readout"
    neutral: ClassVar[Mapping[str, Any]] = {"offset_dn": 0.0}

    def __init__(self, config: Config):
        self.config = config

    def on_array(self, samples, *, geometry, context, rng):
        return samples + self.config.offset_dn if self.config.offset_dn else samples


class Invert:
    """Makes bright what is dark, by a share."""

    class Config(Settings):
        share: float = setting(0.0, help="Share of the negative.", ge=0, le=1)
        steps: int = setting(1, help="Steps of the result.", unit="DN", ge=1, le=64)
        mode: Literal["all", "red"] = setting("all", help="Which channels.")

    stage = "isp"
    neutral: ClassVar[Mapping[str, Any]] = {"share": 0.0}

    def __init__(self, config: Config):
        self.config = config

    def on_array(self, samples, *, geometry, context, rng):
        share = samples.dtype.type(self.config.share)
        return samples * (1 - share) + (255 - samples) * share if share else samples


@dataclass(frozen=True)
class Levels:
    """Mean of each frame of the first and the last camera: a value that only the toys know."""

    episode: Episode
    first_dn: tuple[float, ...]
    last_dn: tuple[float, ...]


class Mean:
    """What is left of frames is their mean."""

    class Config(Settings):
        gain: float = setting(help="Factor on the mean.", ge=0, le=10)

    built: ClassVar[int] = 0

    def __init__(self, config: Config):
        self.config = config
        Mean.built += 1

    def transform(self, frames: FrameBatch, *, exposure: Exposure, memory: dict[str, Any]) -> Levels:
        assert exposure.time_s > 0
        memory["frames"] = memory.get("frames", 0) + len(frames.episode)
        first, last = (
            tuple(self.config.gain * float(image.mean()) for image in frames.images[camera])
            for camera in (0, -1)
        )
        return Levels(frames.episode, first, last)


class Level:
    """Reports how bright the frames are, as a transform tells it."""

    class Config(Settings):
        pass

    scores: ClassVar[tuple[str, ...]] = ("first", "last")

    def __init__(self, config: Config):
        pass

    def begin(self, *, state: State | None) -> LevelScorer:
        return LevelScorer()


class LevelScorer:
    def __init__(self) -> None:
        self._first: list[float] = []
        self._last: list[float] = []

    def update(self, levels: Levels) -> None:
        self._first.extend(levels.first_dn)
        self._last.extend(levels.last_dn)

    def scores(self) -> Scores:
        return {"first": float(np.mean(self._first)), "last": float(np.mean(self._last))}
