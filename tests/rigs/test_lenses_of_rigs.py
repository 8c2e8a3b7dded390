"""Fisheyes on rigs: from settings, from catalogs, and from calibration files of others."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from pydantic import ValidationError

from tacos_framework import Lens, find_catalog
from tacos_framework.camera import pixels_of_rays
from tacos_framework.settings import check
from tacos_plugins.rigs.front_back_sides import FrontBackSidesRig
from tacos_plugins.rigs.lens import LensPart, derived_fit, notes_on_fit
from tacos_plugins.rigs.lens_curve import lens_of_curve
from tacos_plugins.rigs.monocular import MonocularRig
from tacos_plugins.rigs.ring import RingRig
from tacos_plugins.rigs.sensor_part import SensorPart
from tacos_plugins.rigs.stereo import StereoRig

T265 = {"width_px": 848, "height_px": 800, "pixel_um": 3.0}
COEFFICIENTS = (-0.003, 0.054, -0.052, 0.011)
RAYS = np.random.default_rng(0).uniform((-1, -1, 0.3), (1, 1, 1.5), (200, 3))


def one(binning=1.0, **variables):
    rig = MonocularRig(MonocularRig.Config(binning=binning))
    return rig.build(MonocularRig.Variables(sensor=T265, **variables)).cameras[0]


def notes(**variables):
    return " ".join(
        MonocularRig(MonocularRig.Config()).notes(MonocularRig.Variables(sensor=T265, **variables))
    )


@pytest.mark.parametrize("field_deg", [100.0, 163.0, 179.0, 190.0])
def test_stereo_fisheyes_have_the_field_that_is_asked_for(field_deg):
    builder = StereoRig(StereoRig.Config())
    variables = StereoRig.Variables(
        sensor=T265, baseline_m=0.063, hfov_deg=field_deg, projection="equidistant"
    )
    left, right = builder.build(variables).cameras
    assert left.hfov_deg == right.hfov_deg == pytest.approx(field_deg)
    assert left.focal_length_px == pytest.approx(848 / np.radians(field_deg))
    assert builder.derived(variables)["hfov_deg"] == pytest.approx(field_deg)


def test_rings_and_cars_take_fisheyes_too():
    ring = RingRig.Variables(sensor=T265, cameras=4, hfov_deg=190, projection="stereographic")
    assert [c.hfov_deg for c in RingRig(RingRig.Config()).build(ring).cameras] == pytest.approx([190.0] * 4)
    car = FrontBackSidesRig.Variables(
        sensor=T265, front_hfov_deg=60, other_hfov_deg=185, projection="equisolid"
    )
    fields = [c.hfov_deg for c in FrontBackSidesRig(FrontBackSidesRig.Config()).build(car).cameras]
    assert fields == pytest.approx([60, 185, 185, 185])


@pytest.mark.parametrize(
    ("rig", "variables", "said"),
    [
        (
            RingRig,
            {"cameras": 2, "hfov_deg": 190},
            "hfov_deg is a field of view of 190 deg, where a rectilinear",
        ),
        (FrontBackSidesRig, {"front_hfov_deg": 180}, "front_hfov_deg is a field of view of 180 deg"),
        (
            StereoRig,
            {"baseline_m": 0.1, "hfov_deg": 170, "projection": "equidistant", "image_circle_deg": 160},
            "hfov_deg is a field of view of 170 deg, where a equidistant lens has one below 160 deg",
        ),
        (
            MonocularRig,
            {"focal_length_mm": 2, "image_circle_deg": 185},
            "image_circle_deg is 185: .*below 180",
        ),
        (
            MonocularRig,
            {"lens": {"focal_length_mm": 2}, "projection": "equisolid"},
            "projection is the lens's own",
        ),
    ],
)
def test_fields_that_a_projection_cannot_have_are_refused(rig, variables, said):
    with pytest.raises(ValidationError, match=said):
        rig.Variables(sensor=T265, **variables)


# catalogs ---------------------------------------------------------------------------------------------------


def test_every_fisheye_of_the_catalog_with_a_focal_length_makes_a_camera():
    rows = [row for row in find_catalog("lenses_fisheye").rows if row.values.get("focal_length_mm")]
    assert len(rows) == 10
    for row in rows:
        camera = one(lens=row)
        assert camera.lens.projection in ("equidistant", "kannala-brandt")
        assert camera.hfov_deg > 40


def test_a_curve_is_followed_within_a_share_of_the_image_circle():
    for row in find_catalog("lenses_fisheye").rows:
        if (curve := row.values.get("curve")) is None:
            continue
        scale, lens = lens_of_curve(curve)
        terms = np.array(
            [float(t.split("*")[0].replace(" ", "")) for t in curve[6:].replace(" - ", " + -").split(" + ")]
        )
        angle = np.linspace(0, np.radians(lens.half_field_deg), 100)
        stated = sum(factor * angle ** (i + 1) for i, factor in enumerate(terms))
        np.testing.assert_allclose(scale * terms[0] * lens.radius(angle), stated, atol=1.5e-3)


def test_a_curve_that_is_none_is_refused():
    with pytest.raises(ValidationError, match="is not like r/R"):
        LensPart(focal_length_mm=1.0, curve="tan(t)")


def test_fisheyes_may_leave_corners_dark_and_say_so():
    fisheye = {"name": "F", "focal_length_mm": 0.85, "image_circle_mm": 2.4, "projection": "fisheye"}
    camera = one(lens=fisheye)
    assert camera.lens.half_field_deg == pytest.approx(np.degrees(1.2 / 0.85))
    sensor = SensorPart(**T265)
    assert "image_circle_margin_mm" not in derived_fit(LensPart(**fisheye), sensor)
    said = notes(lens=fisheye)
    assert "Not published: the projection of F; it is simulated as equidistant." in said
    assert "leaves 26 % of the image dark" in said  # 1 - pi 1.2^2 / (2.544 2.4), but for what the edges cut
    assert not list(
        notes_on_fit(LensPart(**{**fisheye, "projection": "equisolid", "f_number_min": 2}), sensor)
    )[1:]


def test_a_rectilinear_lens_too_small_for_its_sensor_leaves_corners_dark_where_that_is_allowed():
    small = one(lens={"focal_length_mm": 3.0, "image_circle_mm": 3.0})
    assert small.lens.half_field_deg == pytest.approx(np.degrees(np.arctan(0.5)))
    assert one(lens={"focal_length_mm": 3.0, "image_circle_mm": 4.0}).lens == Lens()


# calibrations -----------------------------------------------------------------------------------------------

ROS = """image_width: 848
image_height: 800
camera_name: left
camera_matrix: {rows: 3, cols: 3, data: [282.5, 0, 420.3, 0, 281.5, 404.1, 0, 0, 1]}
distortion_model: equidistant
distortion_coefficients: {rows: 1, cols: 4, data: [-0.003, 0.054, -0.052, 0.011]}
"""
KALIBR = """cam0:
  camera_model: pinhole
  intrinsics: [282.5, 281.5, 420.3, 404.1]
  distortion_model: equidistant
  distortion_coeffs: [-0.003, 0.054, -0.052, 0.011]
  resolution: [848, 800]
  rostopic: /left
cam1: {camera_model: pinhole}
"""


def opencv_file(path, fisheye, coefficients):
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", 848)
    storage.write("image_height", 800)
    storage.write("camera_matrix", np.array([[282.5, 0, 420.3], [0, 281.5, 404.1], [0, 0, 1]]))
    storage.write("fisheye_model", int(fisheye))
    storage.write("distortion_coefficients", np.array([coefficients]))
    storage.release()
    return str(path)


@pytest.mark.parametrize("kind", ["ros", "kalibr", "opencv"])
def test_a_calibrated_fisheye_images_as_opencv_does(kind, tmp_path):
    path = tmp_path / "camera.yaml"
    if kind == "opencv":
        opencv_file(path, True, COEFFICIENTS)
    else:
        path.write_text(ROS if kind == "ros" else KALIBR)
    camera = one(calibration=str(path), image_circle_deg=163)
    f = np.sqrt(282.5 * 281.5)
    matrix = np.array([[f, 0, 420.3], [0, f, 404.1], [0, 0, 1]])
    expected, _ = cv2.fisheye.projectPoints(
        RAYS[:, None], np.zeros(3), np.zeros(3), matrix, np.array(COEFFICIENTS)
    )
    found = pixels_of_rays(RAYS, camera)
    imaged = np.isfinite(found[:, 0])
    assert imaged.mean() > 0.9
    np.testing.assert_allclose(found[imaged], expected[:, 0][imaged], atol=1e-6)
    assert camera.hfov_deg == pytest.approx(163)
    halved = one(binning=2, calibration=str(path))
    np.testing.assert_allclose(
        pixels_of_rays(RAYS[0], halved), (pixels_of_rays(RAYS[0], camera) + 0.5) / 2 - 0.5, atol=1e-9
    )


def test_a_calibrated_rectilinear_lens_keeps_its_distortion(tmp_path):
    path = opencv_file(tmp_path / "c.yaml", False, (-0.1, 0.02, 0.001, -0.002, 0.0))
    rig = StereoRig(StereoRig.Config())
    left, _ = rig.build(StereoRig.Variables(sensor=T265, baseline_m=0.1, calibration=path)).cameras
    assert left.lens == Lens("rectilinear", (-0.1, 0.02, 0.001, -0.002, 0.0))
    assert left.centre_px == pytest.approx((420.3, 404.1))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            ROS.replace("848", "640"),
            "of images of 640 x 800 pixels, and this camera reads out 848 x 800: calib",
        ),
        (
            ROS.replace("equidistant", "thin_prism"),
            "distortion model 'thin_prism', where plumb_bob",
        ),
        (
            ROS.replace("equidistant", "rational_polynomial").replace("0.011]", "0.011, 0, 0.1]"),
            "6 coefficients of distortion model 'rational_polynomial', where 5 are known",
        ),
        (ROS.replace("282.5", "300"), "focal lengths 300 and 281.5 px, where pixels are square"),
        ("a: 1\n", "it lacks image_width, image_height, camera_matrix, distortion_coefficients"),
        ("cam0: {intrinsics: [1, 1, 1, 1]}\n", "it lacks resolution, distortion_model, distortion_coeffs"),
        ("[1, 2", "expected|YAML"),
        ("1 OPENCV 848 800 282.5", "it has no names of values"),
        ("<opencv_storage>", "not valid XML"),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><a/>", "has a DOCTYPE"),
        (None, "camera.yaml"),
    ],
)
def test_calibrations_that_do_not_fit_are_refused(text, said, tmp_path):
    path = tmp_path / "camera.yaml"
    if text is not None:
        path.write_text(text)
    with pytest.raises(ValidationError, match=said):
        one(calibration=str(path))


ECHO = """header: {frame_id: cam}
height: 800
width: 848
distortion_model: "plumb_bob"
D: [-0.1, 0.02, 0.001, -0.002, 0.01]
K: [282.5, 0.0, 420.3, 0.0, 281.5, 404.1, 0.0, 0.0, 1.0]
---
"""
EUROC = """sensor_type: camera
resolution: [848, 800]
camera_model: pinhole
intrinsics: [282.5, 281.5, 420.3, 404.1]
distortion_model: radial-tangential
distortion_coefficients: [-0.1, 0.02, 0.001, -0.002]
"""
XML = """<?xml version="1.0"?>
<opencv_storage>
<image_Width>848</image_Width>
<image_Height>800</image_Height>
<Camera_Matrix type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt>
  <data>282.5 0. 420.3 0. 281.5 404.1 0. 0. 1.</data></Camera_Matrix>
<Distortion_Coefficients type_id="opencv-matrix"><data>
  -0.1 0.02 0.001 -0.002 0.01</data></Distortion_Coefficients>
</opencv_storage>
"""


@pytest.mark.parametrize(
    "text",
    [
        ECHO,
        ECHO.replace("D:", "d:").replace("K:", "k:").replace("---\n", ""),
        ECHO.replace("plumb_bob", "rational_polynomial").replace("0.01]", "0.01, 0, 0, 0]"),
        EUROC,
        XML,
    ],
)
def test_calibrations_are_read_as_other_programs_write_them(text, tmp_path):
    path = tmp_path / "camera.yaml"
    path.write_text(text)
    camera = one(calibration=str(path))
    assert camera.lens.projection == "rectilinear"
    assert camera.lens.coefficients[:4] == (-0.1, 0.02, 0.001, -0.002)
    assert camera.centre_px == (420.3, 404.1)


@pytest.mark.parametrize(("baseline_m", "told"), [(0.11, False), (0.064, True)])
def test_a_baseline_that_contradicts_the_calibration_is_told(baseline_m, told, tmp_path):
    path = tmp_path / "camchain.yaml"
    second = "cam1: {T_cn_cnm1: [[1, 0, 0, -0.11], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}"
    path.write_text(KALIBR.replace("cam1: {camera_model: pinhole}", second))
    variables = StereoRig.Variables(sensor=T265, baseline_m=baseline_m, calibration=str(path))
    said = " ".join(StereoRig(StereoRig.Config()).notes(variables))
    assert ("camchain.yaml are 0.11 m apart, and baseline_m is 0.064 m" in said) == told


def test_a_calibration_that_is_none_is_told_with_the_formats(tmp_path):
    path = tmp_path / "camera.yaml"
    path.write_text("Camera.fx: 420.5\n")
    _, [fault], _ = check(MonocularRig.Variables, {"sensor": T265, "calibration": str(path)}, str)
    assert "it lacks image_width" in fault.expected
    assert fault.remedy.startswith("Give a file of OpenCV")


def test_a_calibration_is_the_only_word_on_the_lens(tmp_path):
    path = tmp_path / "camera.yaml"
    path.write_text(ROS)
    with pytest.raises(ValidationError, match="calibration and focal_length_mm both say the focal length"):
        one(calibration=str(path), focal_length_mm=2.0)
    with pytest.raises(ValidationError, match="calibration brings a projection of its own"):
        one(calibration=str(path), projection="equidistant")
