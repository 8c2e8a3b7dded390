"""Calibration files, read back by the programs they are for or by their formats' own rules."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_export.camera import describe_cameras, write_camera_files
from tacos_export.camera.noise import describe_noise
from tacos_export.conventions import at_full_resolution
from tacos_framework.camera.geometry import invert_pose, project
from tacos_framework.cli import tacos_main
from tacos_framework.values import Camera, Electrons, Exposure
from tacos_plugins.rigs.monocular import MonocularRig
from tacos_plugins.sensors.affine_noise import AffineNoise
from tacos_plugins.sensors.emva import Emva
from tacos_view import RenderSetup, set_up
from tests.two_boxes import monocular_recipe, plugins_with_boxes, stereo_recipe

BROWN = {"use": "effect.lens-distortion", "k1": -0.1, "k2": 0.02, "p1": 0.001, "p2": -0.002}


def monocular(*effects: dict[str, Any]) -> RenderSetup:
    return set_up(
        monocular_recipe(effects=list(effects)), {"focal_length_mm": 0.6}, plugins=plugins_with_boxes()
    )


def stereo() -> RenderSetup:
    return set_up(stereo_recipe(), {"baseline_m": 0.2, "hfov_deg": 80.0}, plugins=plugins_with_boxes())


def written(setup: RenderSetup, out: Path) -> tuple[Path, list[str]]:
    _, limitations = write_camera_files(out, describe_cameras(setup))
    return out, limitations


def test_opencv_projects_a_point_where_we_do(tmp_path: Path) -> None:
    setup = monocular(BROWN)
    folder, _ = written(setup, tmp_path)
    storage = cv2.FileStorage(str(folder / "camera_opencv.yaml"), cv2.FILE_STORAGE_READ)
    k = storage.getNode("camera_matrix").mat()
    distortion = storage.getNode("distortion_coefficients").mat()
    assert (storage.getNode("image_width").real(), storage.getNode("image_height").real()) == (128, 96)
    (camera,) = (at_full_resolution(each) for each in setup.rig.cameras)
    point = np.array([[0.2, -0.1, 1.0]])
    straight, _ = cv2.projectPoints(point, np.zeros(3), np.zeros(3), k, np.zeros(5))
    ours, _ = project(point, camera, np.eye(4))
    assert straight[0, 0] == pytest.approx(ours[0])
    assert distortion.ravel().tolist() == [-0.1, 0.02, 0.001, -0.002, 0.0]


def test_opencv_stereo_is_rectified_and_as_wide_as_the_baseline(tmp_path: Path) -> None:
    folder, _ = written(stereo(), tmp_path)
    storage = cv2.FileStorage(str(folder / "rig_opencv.yaml"), cv2.FILE_STORAGE_READ)
    assert storage.getNode("R_right").mat() == pytest.approx(np.eye(3))
    assert storage.getNode("T_right").mat().ravel() == pytest.approx([-0.2, 0, 0])


def test_ros_camera_info_has_what_its_parser_asks_for(tmp_path: Path) -> None:
    """The keys and sizes that ROS's camera_calibration_parsers reads; P of the right camera has -f B."""
    folder, _ = written(stereo(), tmp_path)
    info = yaml.safe_load((folder / "right_ros.yaml").read_text())
    sizes = {"camera_matrix": (3, 3), "rectification_matrix": (3, 3), "projection_matrix": (3, 4)}
    for key, (rows, cols) in sizes.items():
        assert (info[key]["rows"], info[key]["cols"], len(info[key]["data"])) == (rows, cols, rows * cols)
    assert info["distortion_model"] == "plumb_bob"
    assert (info["distortion_coefficients"]["rows"], info["distortion_coefficients"]["cols"]) == (1, 5)
    projection = info["projection_matrix"]["data"]
    assert projection[3] == pytest.approx(-0.2 * projection[0])
    assert (info["image_width"], info["image_height"], info["camera_name"]) == (128, 96, "right")


def test_kalibr_chains_the_cameras(tmp_path: Path) -> None:
    folder, limitations = written(stereo(), tmp_path)
    chain = yaml.safe_load((folder / "camchain.yaml").read_text())
    assert list(chain) == ["cam0", "cam1"]
    assert np.array(chain["cam1"]["T_cn_cnm1"])[:3, 3] == pytest.approx([-0.2, 0, 0])
    assert chain["cam0"]["cam_overlaps"] == [1]
    assert len(chain["cam0"]["distortion_coeffs"]) == 4
    assert limitations == []


def test_what_a_format_cannot_say_is_said(tmp_path: Path) -> None:
    folder, limitations = written(monocular({**BROWN, "k3": 0.01}), tmp_path)
    assert not (folder / "camchain.yaml").exists()
    assert limitations == ["camera: Kalibr's radtan has no k3, so there is no camchain.yaml"]


def test_a_fisheye_is_equidistant(tmp_path: Path) -> None:
    folder, _ = written(monocular({"use": "effect.lens-distortion", "model": "fisheye", "k1": 0.1}), tmp_path)
    assert yaml.safe_load((folder / "camera_ros.yaml").read_text())["distortion_model"] == "equidistant"
    assert yaml.safe_load((folder / "camchain.yaml").read_text())["cam0"]["distortion_coeffs"][0] == 0.1


def test_noise_of_the_electron_model_is_what_went_in() -> None:
    """Two models of one camera: the numbers of a data sheet come back out of the photon transfer."""
    known = Electrons("s", quantum_efficiency=0.6, full_well_e=9000, read_noise_e=3.0, dark_current_e_s=0.0)
    camera = Camera("camera", 64, 48, pixel_um=3.0, focal_length_mm=4.0, electrons=known)
    sensor = Emva(Emva.Config(bit_depth=12, black_level_dn=60))
    noise = describe_noise(sensor, camera, Exposure(0.01, 2.0, 0.0))
    assert noise.system_gain_dn_per_e == pytest.approx([(4095 - 60) / 9000] * 3, rel=1e-4)
    assert noise.temporal_dark_noise_e == pytest.approx([3.0] * 3, rel=1e-3)
    assert noise.saturation_capacity_e == pytest.approx([9000] * 3, rel=1e-4)
    assert (noise.quantum_efficiency, noise.black_level_dn, noise.white_level_dn) == (0.6, 60, 4095)


@pytest.mark.parametrize("simulated", [1, 3])
def test_a_camera_that_bins_is_exported_with_the_pixels_it_gives_out(simulated: int) -> None:
    """Of b x b photosites: b^2 times the electrons, and b times the noise of b^2 reads."""
    known = Electrons("s", quantum_efficiency=0.6, full_well_e=9000, read_noise_e=3.0, dark_current_e_s=5.0)
    variables = MonocularRig.Variables(
        focal_length_mm=4.0, sensor={"width_px": 1200, "height_px": 900, "pixel_um": 2.0}, sensor_binning=2
    )
    (camera,) = MonocularRig(MonocularRig.Config(binning=simulated)).build(variables).cameras
    shown = at_full_resolution(replace(camera, electrons=known))
    assert (shown.width_px, shown.height_px, shown.centre_px) == (600, 450, (299.5, 224.5))
    assert shown.focal_length_px == pytest.approx(1000)  # 4 mm over 2 x 2 um
    noise = describe_noise(Emva(Emva.Config()), shown, Exposure(0.01, 2.0, 0.0))
    assert noise.system_gain_dn_per_e == pytest.approx([4095 / 36000] * 3, rel=1e-4)
    assert noise.saturation_capacity_e == pytest.approx([36000] * 3, rel=1e-4)
    dark_e2 = 4 * (3.0**2 + 5.0 * 0.01)
    assert noise.temporal_dark_noise_e == pytest.approx([dark_e2**0.5] * 3, rel=1e-3)
    assert noise.dark_current_e_s == 20.0


def test_noise_predicts_the_variance_that_is_drawn() -> None:
    camera = Camera("camera", 400, 400, pixel_um=1.55, focal_length_mm=4.0)
    exposure = Exposure(0.03, 2.0, 15.0)
    sensor = AffineNoise(AffineNoise.Config(calibration="flea3_imx172"))
    noise = describe_noise(sensor, camera, exposure)
    flat = np.full((1, 400, 400, 3), 100.0, np.float32)
    drawn = sensor.draw(flat, camera=camera, exposure=exposure, rng=np.random.default_rng(1))
    for c in range(3):
        k, dark = noise.system_gain_dn_per_e[c], noise.temporal_dark_noise_dn[c]
        assert drawn[..., c].var() == pytest.approx(k * 100 + dark**2, rel=0.02)


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 8), st.floats(-0.4, 0.4), st.floats(-0.3, 0.3))
def test_full_resolution_sees_a_point_in_the_same_place(binning: int, x: float, y: float) -> None:
    """Edges of the image stay where they are: -0.5 and width - 0.5 in both."""
    camera = Camera("c", 64, 48, pixel_um=2.0, focal_length_mm=0.2 * binning, binning=binning)
    point = np.array([x, y, 1.0])
    small, _ = project(point, camera, np.eye(4))
    large, _ = project(point, at_full_resolution(camera), np.eye(4))
    assert (large + 0.5) / binning - 0.5 == pytest.approx(small)


def test_the_command_writes_a_product_of_a_recipe(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["export", "camera", "headset_quick", "--camera", "flea3", "--out", str(tmp_path)]
    assert tacos_main(arguments) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("FLIR Flea3:\n")
    assert "note: not set: pitch_deg" in printed
    info = yaml.safe_load((tmp_path / "camera_ros.yaml").read_text())
    assert (info["image_width"], info["image_height"]) == (4000, 3000)
    assert info["camera_matrix"]["data"][0] == pytest.approx(3.6e3 / 1.55)
    assert tacos_main([*arguments, "--simulated"]) == 0
    info = yaml.safe_load((tmp_path / "camera_ros.yaml").read_text())
    assert (info["image_width"], info["image_height"]) == (1333, 1000)  # 4000 is no multiple of 3


def test_body_from_camera_is_a_pose(tmp_path: Path) -> None:
    folder, _ = written(monocular(), tmp_path)
    storage = cv2.FileStorage(str(folder / "camera_opencv.yaml"), cv2.FILE_STORAGE_READ)
    pose = storage.getNode("body_from_camera").mat()
    assert pose @ invert_pose(pose) == pytest.approx(np.eye(4))
    assert pose[0, 2] > 0.9  # the optical axis points ahead
