"""Fisheyes in files: rendered, exported, and read back by OpenCV and by our own rigs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from tacos_export.camera import describe_cameras, write_camera_files
from tacos_export.camera.description import lens_of
from tacos_export.dataset.export import export_dataset
from tacos_framework.camera import pixel_rays, pixels_of_rays, project
from tacos_framework.errors import UserError
from tacos_framework.testing.forming import placed
from tacos_plugins.effects.lens_distortion import LensDistortion
from tacos_plugins.rigs.monocular import MonocularRig
from tacos_view import RenderSetup, set_up
from tests.two_boxes import plugins_with_boxes, stereo_recipe

SENSOR = {"name": "small", "width_px": 106, "height_px": 100, "pixel_um": 24.0}
KB = {
    "width_px": 106,
    "height_px": 100,
    "focal_length_px": 35.25,
    "centre_px": [52.5, 49.7],
    "projection": "kannala-brandt",
    "coefficients": [-0.003, 0.054, -0.052, 0.011],
}
FULL = {"name": "full", "width_px": 848, "height_px": 800, "pixel_um": 3.0}
FULL_KB = KB | {"width_px": 848, "height_px": 800, "focal_length_px": 282.0, "centre_px": [424.4, 398.6]}
RIGS: dict[str, dict[str, Any]] = {
    "T265": {"calibration": KB, "image_circle_deg": 163},
    "equidistant 190": {"hfov_deg": 190, "projection": "equidistant"},
    "equisolid 185": {"hfov_deg": 185, "projection": "equisolid"},
    "stereographic 170": {"hfov_deg": 170, "projection": "stereographic"},
}


def fisheyes(name: str, sensor: dict[str, Any] = SENSOR, **changes: Any) -> RenderSetup:
    rig = {"use": "rig.stereo", "sensor": sensor, **RIGS[name], **changes}
    recipe = stereo_recipe(rig=rig, design={"baseline_m": {"between": [0.05, 0.3]}})
    return set_up(recipe, {"baseline_m": 0.064}, plugins=plugins_with_boxes())


@pytest.mark.parametrize("name", RIGS)
def test_opencv_finds_every_pixel_where_the_rendered_image_has_it(name: str, tmp_path: Path) -> None:
    """What each pixel shows, a point of the world by depth and ray, is projected by OpenCV's fisheye."""
    setup = fisheyes(name)
    _, limitations = write_camera_files(tmp_path, describe_cameras(setup))
    matrix, coefficients, _ = _read(tmp_path / "left_opencv.yaml")
    assert len(coefficients) == 4

    frame = next(iter(setup.frames(1, seed=0)))
    view = frame.capture.views[0]
    rays = pixel_rays(view.camera)
    seen = np.isfinite(view.depth_m[0]) & (rays[..., 2] > 0.02)  # OpenCV's divides by z
    assert seen.mean() > 0.5
    points = (view.depth_m[0][..., None] * rays)[seen][:, None].astype(np.float64)
    there, _ = cv2.fisheye.projectPoints(points, np.zeros(3), np.zeros(3), matrix, coefficients)
    rows, columns = np.nonzero(seen)
    np.testing.assert_allclose(there[:, 0], np.column_stack([columns, rows]), atol=1e-3)
    assert any("dark" in said for said in limitations) == (name == "T265")
    assert any("powers of the angle" in said for said in limitations) == name.startswith(
        ("equisolid", "stereo")
    )


@pytest.mark.parametrize("file", ["left_opencv.yaml", "left_ros.yaml", "camchain.yaml"])
def test_our_own_files_are_calibrations_of_the_same_lens(file: str, tmp_path: Path) -> None:
    setup = fisheyes("T265")
    write_camera_files(tmp_path, describe_cameras(setup))
    variables = MonocularRig.Variables(sensor=SENSOR, calibration=str(tmp_path / file), image_circle_deg=163)
    (back,) = MonocularRig(MonocularRig.Config()).build(variables).cameras
    rays = np.random.default_rng(1).normal(size=(300, 3))
    np.testing.assert_allclose(
        pixels_of_rays(rays, back), pixels_of_rays(rays, setup.rig.cameras[0]), atol=1e-9
    )


def test_an_effect_on_a_fisheye_is_in_its_coefficients() -> None:
    camera = fisheyes("T265").rig.cameras[0]
    model, coefficients, said = lens_of([placed(LensDistortion, model="fisheye", k1=0.02, k4=0.001)], camera)
    assert model == "fisheye"
    assert coefficients == pytest.approx((0.017, 0.054, -0.052, 0.012))
    assert not any("moves pixels" in each for each in said)
    _, coefficients, said = lens_of([placed(LensDistortion, k1=0.02)], camera)
    assert coefficients == camera.lens.coefficients
    assert any("moves pixels" in each for each in said)


def test_opencv_undistorts_a_rendered_fisheye_into_the_picture_of_a_pinhole() -> None:
    """The fisheye's light, rectified by OpenCV, against the pinhole's own."""
    setup = fisheyes("equidistant 190")
    camera = setup.rig.cameras[0]
    view = next(iter(setup.frames(1, seed=0))).capture.views[0]
    flat = np.array([[40.0, 0, 31.5], [0, 40.0, 23.5], [0, 0, 1]])
    maps = cv2.fisheye.initUndistortRectifyMap(
        camera.intrinsics, np.zeros(4), np.eye(3), flat, (64, 48), cv2.CV_32FC1
    )
    depth = cv2.remap(view.depth_m[0], *maps, cv2.INTER_NEAREST)
    ids = cv2.remap(view.object_id[0].astype(np.float32), *maps, cv2.INTER_NEAREST)
    x, y = np.meshgrid((np.arange(64) - 31.5) / 40, (np.arange(48) - 23.5) / 40)
    along_axis = depth / np.sqrt(x**2 + y**2 + 1)
    wall_m = 5.0 - view.world_from_camera[0, 0, 3]
    wall = (ids == 0) & (np.abs(y) < 0.2)
    turned = view.world_from_camera[0, 0, :3] @ np.array([x, y, np.ones_like(x)]).reshape(3, -1)
    assert np.median(np.abs(along_axis.ravel() * turned - wall_m)[wall.ravel()]) < 0.02 * wall_m


def test_formats_name_the_fisheye_or_refuse_it(tmp_path: Path) -> None:
    setup = fisheyes("equidistant 190")
    export_dataset(setup, tmp_path / "colmap", "colmap", frames=1)
    lines = (tmp_path / "colmap" / "sparse" / "0" / "cameras.txt").read_text().splitlines()
    assert lines[1].split()[1] == "OPENCV_FISHEYE"
    manifest = json.loads((tmp_path / "colmap" / "frames.json").read_text())
    assert manifest["cameras"]["left"]["depth_along"] == "ray"
    with pytest.raises(UserError, match="rectified images"):
        export_dataset(setup, tmp_path / "kitti", "kitti", frames=1)


def test_what_is_projected_is_seen_where_its_id_is() -> None:
    setup = fisheyes("T265")
    frame = next(iter(setup.frames(1, seed=0)))
    for view in frame.capture.views:
        middle, _ = project(np.array([2.0, -0.5, 1.1]), view.camera, view.world_from_camera[0])
        assert view.object_id[0, round(middle[1]), round(middle[0])] == 1


@pytest.mark.slow
@pytest.mark.parametrize(("name", "changes"), [("T265", {"calibration": FULL_KB}), ("equidistant 190", {})])
def test_opencv_rectifies_a_full_sized_pair_from_its_files(
    name: str, changes: dict[str, Any], tmp_path: Path
) -> None:
    """A point that the left image shows lies in the same row of the rectified right one, at its disparity."""
    setup = fisheyes(name, FULL, **changes)
    write_camera_files(tmp_path, describe_cameras(setup))
    matrices, coefficients, poses = zip(
        *(_read(tmp_path / f"{side}_opencv.yaml") for side in ("left", "right")), strict=True
    )
    right_from_left = np.linalg.inv(poses[1]) @ poses[0]
    size = (FULL["width_px"], FULL["height_px"])
    turn = cv2.fisheye.stereoRectify(
        matrices[0], coefficients[0], matrices[1], coefficients[1], size,
        right_from_left[:3, :3], right_from_left[:3, 3], cv2.CALIB_ZERO_DISPARITY,
    )  # fmt: skip
    frame = next(iter(setup.frames(1, seed=0)))
    left, right = frame.capture.views
    rays = pixel_rays(left.camera)
    seen = np.isfinite(left.depth_m[0]) & (rays[..., 2] > 0.3)
    points = (left.depth_m[0][..., None] * rays)[seen].astype(np.float64)
    in_right = points @ right_from_left[:3, :3].T + right_from_left[:3, 3]
    rectified = [
        cv2.fisheye.undistortPoints(
            pixels_of_rays(each, view.camera)[:, None], matrices[i], coefficients[i], R=turn[i], P=turn[i + 2]
        )[:, 0]
        for i, (each, view) in enumerate(((points, left), (in_right, right)))
    ]
    np.testing.assert_allclose(rectified[0][:, 1], rectified[1][:, 1], atol=0.01)
    along_axis_m = (points @ turn[0].T)[:, 2]
    disparity = rectified[0][:, 0] - rectified[1][:, 0]
    np.testing.assert_allclose(disparity, -turn[3][0, 3] / along_axis_m, atol=0.01)


def _read(file: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Camera matrix, coefficients, and the camera's pose in the body, as OpenCV reads them."""
    storage = cv2.FileStorage(str(file), cv2.FILE_STORAGE_READ)
    assert storage.getNode("fisheye_model").real() == 1
    names = ("camera_matrix", "distortion_coefficients", "body_from_camera")
    matrix, coefficients, pose = (storage.getNode(name).mat() for name in names)
    return matrix, coefficients.ravel(), pose
