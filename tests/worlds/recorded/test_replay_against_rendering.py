"""A recording of our own, replayed through a second camera, beside that camera rendered directly."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest

from tacos_framework import Camera, Capture, Episode, Exposure, FrameBatch, Rig
from tacos_framework.camera import agent_from_camera
from tacos_framework.formation import EpisodeDraws, ImageFormation, PlacedSensor
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer
from tacos_plugins.sensors.emva import Emva
from tacos_plugins.tasks.orb_features import OrbFeatures
from tacos_worlds.bench.textured_target import TexturedTarget
from tacos_worlds.recorded.renderer import RecordedLight
from tacos_worlds.recorded.scene import RecordedScene

LUX = 1000.0
FRAMES = 6
AHEAD = agent_from_camera((0.0, 0.0, 0.0), pitch_deg=0.0)
SOURCE = Camera("source", 320, 240, pixel_um=6.0, focal_length_mm=2.4, colour="mono", agent_from_camera=AHEAD)
SOURCE_EXPOSURE = Exposure(0.002, 2.0, 0.0)
GOOD = {"quantum_efficiency": 0.8, "full_well_e": 40_000.0, "read_noise_e": 3.0, "dark_current_e_s": 0.0}
POOR = {"quantum_efficiency": 0.3, "full_well_e": 15_000.0, "read_noise_e": 250.0, "dark_current_e_s": 0.0}
SECOND = Camera("second", 130, 90, pixel_um=6.0, focal_length_mm=1.2, colour="mono", agent_from_camera=AHEAD)


def sensor(figures: dict[str, float], bits: int) -> Emva:
    return Emva(Emva.Config(bit_depth=bits, **figures))


@cache
def renderer() -> ModernglRenderer:
    return ModernglRenderer(ModernglRenderer.Config())


@cache
def walk(seed: int) -> Episode:
    config = TexturedTarget.Config(
        size_m=0.6,
        distance_m=0.5,
        tilt_deg=25,
        colourful=False,
        texture_px=1024,
        speed_m_s=0.5,
        frames=FRAMES,
    )
    return TexturedTarget(config).episode(rng=np.random.default_rng(seed), illumination_lux=LUX)


def light(episode: Episode, camera: Camera, exposure: Exposure) -> Capture:
    """Rendered, and averaged over 12 moments of the exposure."""
    moments = (np.arange(12) + 0.5) / 12 - 0.5
    taken = [
        renderer().capture(
            replace(episode, time_s=episode.time_s + moment * exposure.time_s),
            rig=Rig((camera,)),
            exposure=exposure,
        )
        for moment in moments
    ]
    mean = np.mean([each.views[0].luminance_cd_m2 for each in taken], axis=0)
    whole = renderer().capture(episode, rig=Rig((camera,)), exposure=exposure)
    return replace(whole, views=(replace(whole.views[0], luminance_cd_m2=mean),))


def files(capture: Capture, chosen: Emva, exposure: Exposure, seed: int) -> FrameBatch:
    placed = PlacedSensor("sensor.emva", "frames", chosen)
    return ImageFormation(exposure).expose(capture, placed, EpisodeDraws(seed, ("truth",)))


def record(folder: Path, seed: int) -> tuple[Path, float]:
    """Frames of the source in a folder, and their mean luminance [cd/m2]."""
    capture = light(walk(seed), SOURCE, SOURCE_EXPOSURE)
    batch = files(capture, sensor(GOOD, 12), SOURCE_EXPOSURE, seed)
    folder.mkdir()
    lines = ["file,taken_ns,exposure_ms"]
    for number, image in enumerate(batch.images[0]):
        cv2.imwrite(str(folder / f"{number}.png"), image[..., 0])
        lines.append(
            f"{number}.png,{round(walk(seed).time_s[number] * 1e9) + 10**9},{SOURCE_EXPOSURE.time_s * 1e3}"
        )
    (folder / "times.csv").write_text("\n".join(lines))
    return folder, float(capture.views[0].luminance_cd_m2.mean())


def replayed(
    folder: Path, mean_cd_m2: float, camera: Camera, exposure: Exposure
) -> tuple[RecordedScene, Capture]:
    scene = RecordedScene(
        RecordedScene.Config(
            recording=str(folder),
            response="linear",
            mosaic="none",
            hfov_deg=SOURCE.hfov_deg,
            mean_luminance_cd_m2=mean_cd_m2,
            frames=FRAMES,
        )
    )
    episode = scene.episode(rng=np.random.default_rng(0), illumination_lux=LUX)
    shown = RecordedLight(RecordedLight.Config()).capture(episode, rig=Rig((camera,)), exposure=exposure)
    return scene, shown


def inliers(batch: FrameBatch) -> float:
    scorer = OrbFeatures(OrbFeatures.Config(features=300, border_px=12, fast_threshold=10)).begin()
    for at in range(FRAMES):
        capture = batch.capture
        view = capture.views[0].frame(at)
        one = Capture(capture.episode[at : at + 1], (view,))
        scorer.update(replace(batch, capture=one, images=(batch.images[0][at : at + 1],), dn_per_electron=()))
    return scorer.scores()["inliers"]


@pytest.mark.parametrize("exposure_ms", [2.0, 16.0])
def test_a_second_camera_sees_of_a_recording_what_it_sees_of_the_world(
    tmp_path: Path, exposure_ms: float
) -> None:
    exposure = Exposure(exposure_ms * 1e-3, 2.0 * (exposure_ms / 2) ** 0.5, 0.0)
    differences, scores = [], []
    for seed in range(6):
        folder, mean_cd_m2 = record(tmp_path / str(seed), seed)
        scene, shown = replayed(folder, mean_cd_m2, SECOND, exposure)
        poor = sensor(POOR, 8)
        assert not scene.not_shown(Rig((SECOND,)), exposure=exposure, sensors=[poor], illumination_lux=LUX)
        again = files(shown, poor, exposure, seed)
        direct = files(light(walk(seed), SECOND, exposure), poor, exposure, seed + 100)
        differences.append(again.images[0].astype(float) - direct.images[0])
        scores.append((inliers(again), inliers(direct)))
    again_scores, direct_scores = np.array(scores).T
    scatter = float(np.std(direct_scores, ddof=1))
    assert abs(np.mean(differences)) < 0.02 * 128
    assert abs(np.mean(again_scores - direct_scores)) < scatter
