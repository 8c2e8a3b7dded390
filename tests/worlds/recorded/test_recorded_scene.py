"""``scene.recorded``: what it refuses, and how noise is counted."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from tacos_framework import Camera, Exposure, Rig, UserError
from tacos_framework.camera import agent_from_camera
from tacos_framework.formation import EpisodeDraws, ImageFormation, PlacedSensor
from tacos_plugins.sensors.emva import Emva
from tacos_worlds.recorded.renderer import RecordedLight
from tacos_worlds.recorded.scene import RecordedScene

MS = 4.0
LUX = 300.0
NOISY = {"quantum_efficiency": 0.5, "full_well_e": 10_000.0, "read_noise_e": 100.0, "dark_current_e_s": 0.0}
CLEAN = {"quantum_efficiency": 0.9, "full_well_e": 2e4, "read_noise_e": 1.0, "dark_current_e_s": 0.0}


def recorded(
    folder: Path, *, noise_dn: float = 80.0, level_dn: float = 2000.0, **settings: object
) -> RecordedScene:
    """A ramp of grey at rest, 12 bits, whose noise is known."""
    rng = np.random.default_rng(2)
    lines = ["file,taken_ns,exposure_ms"]
    for frame in range(8):
        samples = np.linspace(0.6, 1.4, 96) * level_dn + rng.normal(0, noise_dn, (64, 96))
        samples[0, 0] = 4095
        cv2.imwrite(str(folder / f"{frame}.png"), np.clip(samples, 0, 4095).astype(np.uint16))
        lines.append(f"{frame}.png,{frame * 50_000_000},{MS}")
    (folder / "times.csv").write_text("\n".join(lines))
    given = {"recording": str(folder), "response": "linear", "mosaic": "none", "hfov_deg": 50.0, "frames": 8}
    return RecordedScene(RecordedScene.Config.model_validate({**given, **settings}))


def camera(width_px: int = 48, height_px: int = 32, hfov_deg: float = 49.0, **settings: object) -> Camera:
    focal_mm = width_px / 2 / np.tan(np.radians(hfov_deg / 2)) * 6e-3
    pose = agent_from_camera((0.0, 0.0, 0.0), pitch_deg=0.0)
    return Camera(
        "c", width_px, height_px, 6.0, focal_mm, **{"agent_from_camera": pose, "colour": "mono", **settings}
    )  # type: ignore[arg-type]


def refused(
    scene: RecordedScene, chosen: Camera, ms: float = MS, figures: dict[str, float] = NOISY
) -> dict[str, str]:
    sensors = [Emva(Emva.Config(**figures, bit_depth=12))]
    exposure = Exposure(ms * 1e-3, 2.0, 0.0)
    return dict(scene.not_shown(Rig((chosen,)), exposure=exposure, sensors=sensors, illumination_lux=LUX))


def test_each_lack_of_the_source_is_refused_by_name(tmp_path: Path) -> None:
    scene = recorded(tmp_path)
    assert refused(scene, camera()) == {}
    assert set(refused(scene, camera(hfov_deg=60))) == {"wider view"}
    assert set(refused(scene, camera(width_px=192, height_px=128))) == {"finer detail"}
    assert set(refused(scene, camera(), figures=CLEAN)) == {"less noise"}
    assert refused(scene, camera(), ms=1.0) == {}, "at rest a longer exposure has no more blur"


def test_clipped_highlights_are_refused_to_cameras_that_would_show_them(tmp_path: Path) -> None:
    scene = recorded(tmp_path, level_dn=4020.0)
    assert "highlights" in refused(scene, camera(), figures={**NOISY, "full_well_e": 60_000.0})


def test_a_second_camera_beside_the_first_is_refused(tmp_path: Path) -> None:
    scene = recorded(tmp_path)
    pose = agent_from_camera((0.0, -0.1, 0.0), pitch_deg=0.0)
    rig = Rig((camera(), Camera("right", 48, 32, 6.0, 0.4, agent_from_camera=pose, colour="mono")))
    said = scene.not_shown(rig, exposure=Exposure(MS * 1e-3, 2.0), sensors=[], illumination_lux=LUX)
    assert "0.1 m" in said["another place"]


@pytest.mark.parametrize(
    ("width_px", "height_px", "hfov_deg"), [(96, 64, 50.0), (48, 32, 50.0), (40, 26, 49.0)]
)
def test_noise_of_the_source_is_not_added_twice(
    tmp_path: Path, width_px: int, height_px: int, hfov_deg: float
) -> None:
    scene, exposure = recorded(tmp_path, noise_dn=40.0), Exposure(MS * 1e-3, 2.0, 0.0)
    chosen, sensor = camera(width_px, height_px, hfov_deg), Emva(Emva.Config(**NOISY, bit_depth=12))
    episode = scene.episode(rng=np.random.default_rng(0), illumination_lux=LUX)
    capture = RecordedLight(RecordedLight.Config()).capture(episode, rig=Rig((chosen,)), exposure=exposure)
    batch = ImageFormation(exposure).expose(
        capture, PlacedSensor("sensor.emva", "frames", sensor), EpisodeDraws(1, ())
    )
    found = batch.images[0].astype(float)
    shown = capture.views[0].luminance_cd_m2.mean(0, keepdims=True)
    wanted = sensor.expect(shown, camera=chosen, exposure=exposure)
    variance = sensor.moments(wanted, camera=chosen, exposure=exposure)[1]
    assert found.mean() == pytest.approx(float(wanted.mean()), rel=0.01)
    assert found.var(0, ddof=1).mean() == pytest.approx(float(variance.mean()) + 1 / 12, rel=0.05)


def test_a_folder_of_whose_camera_nobody_knows_the_view_says_what_to_state(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="the field of view of its camera is unknown"):
        recorded(tmp_path, hfov_deg=None)


def test_episodes_are_stretches_of_their_own(tmp_path: Path) -> None:
    scene = recorded(tmp_path, frames=2)
    firsts = {
        scene.episode(rng=np.random.default_rng(seed), illumination_lux=LUX).first_index for seed in range(40)
    }
    assert firsts == {0, 2, 4, 6}
    assert any("4 stretches of 2 frames" in remark for remark in scene.remarks)
