"""A simulated measuring bench: a target rendered once, and frames of it with fresh noise."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from tacos_framework import Capture, Exposure, FrameBatch, Plugins, Rig, Settings, Use, setting
from tacos_framework.formation import EpisodeDraws, ImageFormation, PlacedSensor, captured
from tacos_plugins.building import build, episode_of
from tacos_plugins.noise_calibration.frame_files import FrameStack, stack_of


class CameraSetting(Settings):
    exposure_ms: float = setting(help="Exposure time.", unit="ms", gt=0)
    gain_db: float = setting(help="Gain.", unit="dB")
    f_number: float = setting(2.0, help="Focal length over aperture.", gt=0)

    def as_exposure(self) -> Exposure:
        return Exposure(self.exposure_ms * 1e-3, self.f_number, self.gain_db)

    def __str__(self) -> str:
        return f"{self.exposure_ms:g} ms, {self.gain_db:g} dB"


class NoiseBench(Settings):
    """A target, its light, and how many frames are taken of it."""

    scene: Use = setting(Use(use="scene.grey-bars"), help="The target.")
    renderer: Use = setting(Use(use="renderer.moderngl"), help="Its renderer.")
    illumination_lux: float = setting(2000.0, help="Illuminance on the target.", unit="lux", gt=0)
    frames: int = setting(16, help="Frames per setting.", ge=2, le=1000)


class SimulatedCamera(Settings):
    rig: Use = setting(help="The rig; all its variables are given here.")
    sensor: Use = setting(help="The sensor model.")


def capture_of(bench: NoiseBench, rig: Rig, exposure: Exposure, plugins: Plugins) -> Capture:
    """The light of one frame of the target."""
    scene = build(bench.scene, "scene", plugins)
    episode = episode_of(scene, rng=np.random.default_rng(0), illumination_lux=bench.illumination_lux)
    renderer = build(bench.renderer, "renderer", plugins)
    return captured(renderer, rig, partial(renderer.capture, episode[:1], exposure=exposure))


def take_frames(
    sensor: Any, capture: Capture, exposure: Exposure, frames: int, draws: EpisodeDraws
) -> tuple[FrameStack, FrameBatch]:
    """Frames of the first camera with fresh noise each, and one batch that tells their levels."""
    batches = [expose(sensor, capture, exposure, draws, frame) for frame in range(frames)]
    images = np.concatenate([batch.images[0] for batch in batches])
    return stack_of(images, "the rendered frames"), batches[0]


def expose(
    sensor: Any, capture: Capture, exposure: Exposure, draws: EpisodeDraws, frame: int = 0
) -> FrameBatch:
    """Frames of a capture of one frame, without effects: the bench measures the sensor alone.

    - `capture`: of one frame, which may be exposed any number of times.
    - `draws`: what the noise is for.
    - `frame`: which of the exposures of this capture; each has noise of its own.
    """
    of_frame = replace(capture, episode=replace(capture.episode, first_frame=frame))
    use = f"sensor.{type(sensor).__name__}"
    taken = ImageFormation(exposure).expose(of_frame, PlacedSensor(use, "frames", sensor), draws)
    return replace(taken, capture=capture)
