"""Rigs: cameras where they should be, as wide as they should be, and their derived quantities."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from tacos_framework import PINHOLE
from tacos_framework.camera.geometry import invert_pose, project
from tacos_framework.catalog import CatalogPart, load_cameras
from tacos_plugins.rigs.monocular import MonocularRig
from tacos_plugins.rigs.optics import Optics, optics_for
from tacos_plugins.rigs.sensor_part import SensorPart
from tacos_plugins.rigs.stereo import StereoRig

FLEA3 = {"name": "IMX172", "width_px": 4000, "height_px": 3000, "pixel_um": 1.55, "shutter": "rolling"}
PAPER_STEREO = {"width_px": 991, "height_px": 495, "pixel_um": 1.55}


def monocular(config=None, **variables):
    builder = MonocularRig(MonocularRig.Config(**(config or {})))
    return builder, MonocularRig.Variables(**{"focal_length_mm": 3.6, "sensor": FLEA3, **variables})


def stereo(config=None, **variables):
    builder = StereoRig(StereoRig.Config(**(config or {})))
    return builder, StereoRig.Variables(**{"baseline_m": 0.12, "sensor": PAPER_STEREO, **variables})


def test_the_flea3_of_the_paper():
    builder, variables = monocular()
    derived = builder.derived(variables)
    assert derived["sensor_width_mm"] == pytest.approx(6.2)
    assert derived["sensor_height_mm"] == pytest.approx(4.65)
    assert derived["megapixels"] == pytest.approx(12.0)
    assert derived["hfov_deg"] == pytest.approx(2 * math.degrees(math.atan(6.2 / 7.2)))
    assert derived["vfov_deg"] == pytest.approx(2 * math.degrees(math.atan(4.65 / 7.2)))
    assert derived["dfov_deg"] == pytest.approx(2 * math.degrees(math.atan(7.75 / 7.2)))
    assert derived["pixels_per_deg"] == pytest.approx(4000 / 6.2 * 3.6 * math.tan(math.radians(1)), rel=1e-3)


@given(binning=st.floats(1, 16))
def test_binning_keeps_the_field_of_view_and_the_real_photosite(binning):
    builder, variables = monocular({"binning": binning})
    (camera,) = builder.build(variables).cameras
    assert camera.pixel_um == 1.55
    assert camera.binning == binning
    assert abs(camera.width_px * binning - 4000) <= binning / 2
    # The size is rounded to whole pixels, so the simulated field differs by up to half a pixel at each side.
    half_pixel_deg = math.degrees(0.5 / camera.focal_length_px)
    assert abs(camera.hfov_deg - builder.derived(variables)["hfov_deg"]) <= 2 * half_pixel_deg
    assert builder.derived(variables)["megapixels"] == pytest.approx(12.0)


def test_a_tiny_sensor_keeps_one_pixel():
    builder, variables = monocular({"binning": 16}, sensor={"width_px": 4, "height_px": 4, "pixel_um": 3})
    (camera,) = builder.build(variables).cameras
    assert (camera.width_px, camera.height_px) == (1, 1)


@pytest.mark.parametrize("pitch_deg", [-30.0, 0.0, 25.0])
def test_pitch_is_positive_up_and_the_camera_sits_above_the_eye(pitch_deg):
    builder, variables = monocular({"height_above_eye_m": 0.05}, pitch_deg=pitch_deg)
    (camera,) = builder.build(variables).cameras
    pitch = math.radians(pitch_deg)
    ahead = (2 * math.cos(pitch), 0.0, 0.05 + 2 * math.sin(pitch))
    pixel, depth_m = project(ahead, camera, camera.agent_from_camera)
    np.testing.assert_allclose(pixel, camera.centre_px, atol=1e-9)
    assert depth_m == pytest.approx(2.0)


def test_stereo_cameras_are_parallel_level_and_symmetric():
    builder, variables = stereo(hfov_deg=72, pitch_deg=-10)
    left, right = builder.build(variables).cameras
    np.testing.assert_array_equal(left.agent_from_camera[:3, :3], right.agent_from_camera[:3, :3])
    np.testing.assert_allclose(left.agent_from_camera[:3, 3], [0, 0.06, 0])
    np.testing.assert_allclose(right.agent_from_camera[:3, 3], [0, -0.06, 0])
    # A camera's x axis points to the agent's right, so the right camera lies on it.
    in_left = invert_pose(left.agent_from_camera) @ right.agent_from_camera
    np.testing.assert_allclose(in_left[:3, 3], [0.12, 0, 0], atol=1e-12)


@given(depth_m=st.floats(0.5, 100), y_m=st.floats(-1, 1), z_m=st.floats(-1, 1), baseline_m=st.floats(0.01, 3))
def test_disparity_is_focal_length_times_baseline_over_depth(depth_m, y_m, z_m, baseline_m):
    builder, variables = stereo(hfov_deg=90, baseline_m=baseline_m)
    left, right = builder.build(variables).cameras
    rotations = [cv2.Rodrigues(invert_pose(camera.agent_from_camera)[:3, :3])[0] for camera in (left, right)]
    shifts = [invert_pose(camera.agent_from_camera)[:3, 3] for camera in (left, right)]
    point = np.array([[depth_m, y_m, z_m]])
    (xl, yl), (xr, yr) = (
        cv2.projectPoints(point, rotation, shift, camera.intrinsics, None)[0].ravel()
        for camera, rotation, shift in zip((left, right), rotations, shifts, strict=True)
    )
    assert yl == pytest.approx(yr, abs=1e-6)
    assert xl - xr == pytest.approx(left.focal_length_px * baseline_m / depth_m, rel=1e-6, abs=1e-6)


def test_field_of_view_and_focal_length_describe_the_same_stereo_camera():
    builder, by_field = stereo(hfov_deg=87)
    derived = builder.derived(by_field)
    _, by_focal_length = stereo(focal_length_mm=optics_for(991 * 1.55e-3, 87, PINHOLE).focal_length_mm)
    assert derived == pytest.approx(builder.derived(by_focal_length))
    assert derived["hfov_deg"] == pytest.approx(87)
    assert derived["baseline_m"] == 0.12
    assert builder.build(by_field).cameras[0].hfov_deg == pytest.approx(87)


@pytest.mark.parametrize(
    ("name", "baseline_m", "hfov_deg", "focal_baseline_px_m"),
    [("realsense_d450", 0.095, 87, 49.6), ("zed_2i", 0.12, 72, 81.8)],
)
def test_the_cameras_the_paper_compares_with(name, baseline_m, hfov_deg, focal_baseline_px_m):
    [camera] = load_cameras([name])
    assert camera.rig == "rig.stereo"
    assert dict(camera.fixes) == {"baseline_m": baseline_m, "hfov_deg": hfov_deg}
    builder, variables = stereo(**camera.fixes)
    left, _ = builder.build(variables).cameras
    assert (left.width_px, left.height_px) == (991, 495)  # 1.536 x 0.768 mm at 1.55 um
    assert left.focal_length_px * variables.baseline_m == pytest.approx(focal_baseline_px_m, abs=0.1)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"baseline_m": 0.0}, "greater than 0"),
        ({"baseline_m": -0.1}, "greater than 0"),
        ({"baseline_m": float("inf")}, "finite"),
        ({"hfov_deg": 0.0}, "greater than 0"),
        (
            {"hfov_deg": 180.0},
            "hfov_deg is a field of view of 180 deg, where a rectilinear lens has one below 180",
        ),
        ({"hfov_deg": float("nan")}, "finite"),
    ],
)
def test_degenerate_stereo_cameras_are_refused(wrong, said):
    with pytest.raises(ValidationError, match=said):
        stereo(**{"hfov_deg": 70, **wrong})


@pytest.mark.parametrize("given", [{}, {"hfov_deg": 80, "focal_length_mm": 3}])
def test_stereo_needs_exactly_one_of_field_and_focal_length(given):
    with pytest.raises(ValidationError, match="exactly one of hfov_deg and focal_length_mm"):
        stereo(**given)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"focal_length_mm": 0}, "greater than 0"),
        ({"focal_length_mm": float("nan")}, "finite"),
        ({"pitch_deg": 91}, "less than or equal to 90"),
        ({"sensor": {"width_px": 0, "height_px": 3, "pixel_um": 1}}, "greater than or equal to 1"),
        ({"sensor": {"width_px": 640, "height_px": 480}}, "pixel_um"),
    ],
)
def test_impossible_cameras_are_refused(wrong, said):
    with pytest.raises(ValidationError, match=said):
        monocular(**wrong)


@pytest.mark.parametrize(
    ("column", "meant"), [("width", "width_px"), ("pixel", "pixel_um"), ("read_noise", "read_noise_e")]
)
def test_a_sensor_whose_column_lacks_its_unit_is_refused(column: str, meant: str):
    given = {"name": "mine", "width_px": 640, "height_px": 480, "pixel_um": 3.0, "width_mm": 1.92}
    assert SensorPart.model_validate(given).width_px == 640
    with pytest.raises(ValidationError, match=f"{meant}, with its unit, in place of {column}"):
        SensorPart.model_validate({**given, column: 320})


def test_a_sensor_may_come_as_a_catalog_part_whose_other_columns_do_not_matter():
    row = CatalogPart("IMX172", {key: value for key, value in FLEA3.items() if key != "name"})
    _, variables = monocular(sensor=row)
    assert variables.sensor == SensorPart(
        name="IMX172", width_px=4000, height_px=3000, pixel_um=1.55, shutter="rolling"
    )


@given(size_mm=st.floats(0.1, 50), field_deg=st.floats(1, 170))
def test_focal_length_and_field_of_view_undo_each_other(size_mm, field_deg):
    optics = optics_for(size_mm, field_deg, PINHOLE)
    assert optics.field_of_view_deg(size_mm) == pytest.approx(field_deg)
    assert optics.focal_length_mm == size_mm / (2 * math.tan(math.radians(field_deg) / 2))
    assert Optics(optics.focal_length_mm).field_of_view_deg(size_mm) == pytest.approx(field_deg)


LENS = {"name": "L", "focal_length_mm": 3.6, "f_number_min": 1.8, "image_circle_mm": 9.0, "mount": "C"}


def with_lens(sensor=FLEA3, **changed):
    builder = MonocularRig(MonocularRig.Config())
    return builder, MonocularRig.Variables(sensor=sensor, lens={**LENS, **changed})


def test_a_lens_stands_for_its_focal_length():
    builder, by_lens = with_lens()
    _, by_focal_length = monocular()
    derived = builder.derived(by_lens)
    plain = builder.derived(by_focal_length)
    assert {name: derived[name] for name in plain} == plain
    assert set(derived) - set(plain) == {"f_number_min", "image_circle_margin_mm"}  # no mounts are known
    assert derived["image_circle_margin_mm"] == pytest.approx(9.0 - 7.75)
    assert builder.build(by_lens).cameras[0].intrinsics == pytest.approx(
        builder.build(by_focal_length).cameras[0].intrinsics
    )


@pytest.mark.parametrize(
    ("mount", "mounts", "fits"),
    [
        ("C", "C", 1.0),
        ("C", "CS", 1.0),  # with a ring of 5 mm
        ("CS", "C", 0.0),  # its flange is too far from the sensor
        ("CS", "C, CS", 1.0),
        ("M12", "C, CS", 0.0),
        ("M12", "C, CS, M12", 1.0),
        ("F", "F", 1.0),
    ],
)
def test_a_lens_fits_the_mounts_a_camera_is_sold_with(mount, mounts, fits):
    builder, variables = with_lens({**FLEA3, "mounts": mounts}, mount=mount)
    assert builder.derived(variables)["mount_fits"] == fits


def test_what_a_buyer_should_know_of_a_lens():
    builder, variables = with_lens({**FLEA3, "mounts": "CS"}, distortion_percent=-3.0)
    assert list(builder.notes(variables)) == [
        "L needs a ring of 5 mm on a CS camera.",
        "L distorts by -3 %; images are simulated without it, unless the recipe has an effect of lens "
        "distortion.",
    ]
    builder, unknown = with_lens(f_number_min=None, image_circle_mm=None, mount=None)
    assert list(builder.notes(unknown)) == [
        "Not published: the image circle of L; ask for one of at least 7.8 mm, the diagonal of IMX172.",
        "Not published: the smallest f-number of L.",
        "Not published: the mount of L and the mounts of cameras with IMX172; check that they fit.",
        "Not published: the distortion of L; images are simulated without it.",
    ]
    builder, wrong = with_lens({**FLEA3, "mounts": "M12"})
    assert "L has mount C; cameras with IMX172 are sold for M12." in list(builder.notes(wrong))
    builder, without = monocular()
    assert list(builder.notes(without)) == []


@pytest.mark.parametrize("given", [{"focal_length_mm": None}, {"lens": LENS}])
def test_a_camera_needs_exactly_one_of_focal_length_and_lens(given):
    with pytest.raises(ValidationError, match="exactly one of focal_length_mm and lens"):
        monocular(**given)


@given(share=st.floats(0.05, 1.0))
def test_a_region_of_interest_crops_the_view_and_leaves_pixels_as_they_are(share):
    whole_builder, whole = monocular({"binning": 2})
    builder, variables = monocular({"binning": 2}, roi_height=share)
    camera, full = builder.build(variables).cameras[0], whole_builder.build(whole).cameras[0]
    assert camera.focal_length_px == full.focal_length_px
    assert camera.width_px == full.width_px
    assert camera.height_px == pytest.approx(1500 * share, abs=1)
    # A point at the edge of the region lies at the same angle in both.
    derived, of_all = builder.derived(variables), whole_builder.derived(whole)
    half = math.tan(math.radians(of_all["vfov_deg"]) / 2) * variables.read_out.height_px / 3000
    assert math.tan(math.radians(derived["vfov_deg"]) / 2) == pytest.approx(half)
    assert derived["hfov_deg"] == of_all["hfov_deg"]
    assert derived["megapixels"] == pytest.approx(4000 * variables.read_out.height_px * 1e-6)


def test_both_cameras_of_a_stereo_rig_have_the_region():
    builder, variables = stereo(focal_length_mm=2.0, roi_width=0.5, roi_height=0.4)
    assert {(camera.width_px, camera.height_px) for camera in builder.build(variables).cameras} == {
        (496, 198)
    }


def test_a_lens_need_only_cover_the_region():
    lens = {"name": "small", "focal_length_mm": 4.0, "image_circle_mm": 5.0}
    builder, variables = monocular(focal_length_mm=None, lens=lens)
    assert builder.derived(variables)["image_circle_margin_mm"] < 0  # 7.75 mm across the corners
    builder, variables = monocular(focal_length_mm=None, lens=lens, roi_width=0.6, roi_height=0.6)
    assert builder.derived(variables)["image_circle_margin_mm"] == pytest.approx(5 - 0.6 * 7.75)


@given(binning=st.integers(1, 16), simulated=st.sampled_from([1.0, 2.0, 3.5]))
def test_a_camera_that_bins_has_fewer_larger_pixels_and_nearly_the_same_view(binning, simulated):
    builder, variables = monocular({"binning": simulated}, sensor_binning=binning)
    _, whole = monocular()
    (camera,) = builder.build(variables).cameras
    assert (camera.pixel_um, camera.binning) == (1.55, simulated * binning)
    assert camera.simulated_binning == pytest.approx(simulated)
    assert camera.focal_length_px == pytest.approx(3600 / (1.55 * simulated * binning))
    assert camera.width_px == max(1, round(4000 // binning / simulated))
    derived, of_all = builder.derived(variables), builder.derived(whole)
    assert derived["megapixels"] == pytest.approx((4000 // binning) * (3000 // binning) * 1e-6)
    assert derived["pixels_per_deg"] == pytest.approx(of_all["pixels_per_deg"] / binning)
    assert 0 <= of_all["hfov_deg"] - derived["hfov_deg"] < 0.4  # less than a block of photosites is left over


def test_the_sensor_bins_within_the_region_of_interest():
    builder, variables = monocular(roi_height=0.5, sensor_binning=4)
    (camera,) = builder.build(variables).cameras
    assert (camera.width_px, camera.height_px) == (1000, 375)
    assert camera.centre_px == (499.5, 187)
