"""Effects that move pixels, against scenes looked up where OpenCV says they are seen."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from opencv_undistortion import undistorted
from pydantic import ValidationError

from tacos_framework.camera.geometry import pixel_rays
from tacos_framework.testing.forming import placed, with_effect
from tacos_framework.testing.samples import sample_capture, sample_world
from tacos_framework.values import (
    Camera,
    Capture,
    ContextMissing,
    Episode,
    ImageContext,
    Lens,
    Trajectory,
    View,
)
from tacos_plugins.effects.focal_length_error import FocalLengthError
from tacos_plugins.effects.lateral_chromatic_aberration import LateralChromaticAberration
from tacos_plugins.effects.lens_distortion import LensDistortion
from tacos_plugins.effects.pose_error import PoseError
from tacos_plugins.effects.rolling_shutter import RollingShutter
from tests.effects.light_arrays import GEOMETRY, INSIDE, light, pattern, run

Y, X = np.mgrid[:72, :96].astype(np.float64)
CX, CY = GEOMETRY.centre_px
F = GEOMETRY.focal_length_px
K = np.array([[F, 0, CX], [0, F, CY], [0, 0, 1]])


def applied(effect, capture, **settings):
    return with_effect(capture, placed(effect, **settings))


def test_another_focal_length_magnifies_about_the_principal_point():
    found = run(FocalLengthError, light(), scale=1.1, dx_px=2.0, dy_px=-1.0)
    expected = light(lambda x, y: pattern(CX + (x - 2 - CX) / 1.1, CY + (y + 1 - CY) / 1.1))
    np.testing.assert_allclose(found[INSIDE], expected[INSIDE], atol=0.02)


@pytest.mark.parametrize("coefficients", [{"k1": -0.1, "k2": 0.02}, {"k1": 0.15, "p1": 0.01, "p2": -0.01}])
def test_a_lens_images_the_scene_where_opencv_undistorts_it_to(coefficients):
    found = run(LensDistortion, light(), **coefficients)
    k1, k2, p1, p2 = (coefficients.get(name, 0.0) for name in ("k1", "k2", "p1", "p2"))
    pixels = np.stack([X.ravel(), Y.ravel()], axis=1)[:, None]
    seen = undistorted(pixels, K, np.array([k1, k2, p1, p2]), K)
    expected = pattern(seen[:, 0], seen[:, 1]).reshape(X.shape)
    inside = (seen[:, 0] > 8) & (seen[:, 0] < 87) & (seen[:, 1] > 8) & (seen[:, 1] < 63)
    difference = (found[0, :, :, 0] - expected).ravel()[inside]
    assert np.abs(difference).max() < 0.02


def test_a_fisheye_images_the_scene_where_opencv_does():
    found = run(LensDistortion, light(), model="fisheye", k1=0.02)
    pixels = np.stack([X.ravel(), Y.ravel()], axis=1)[:, None]
    seen = cv2.fisheye.undistortPoints(pixels, K, np.array([0.02, 0, 0, 0]), None, K)[:, 0]
    expected = pattern(seen[:, 0], seen[:, 1]).reshape(X.shape)
    inside = (seen[:, 0] > 8) & (seen[:, 0] < 87) & (seen[:, 1] > 8) & (seen[:, 1] < 63)
    assert np.abs((found[0, :, :, 0] - expected).ravel()[inside]).max() < 0.02


@pytest.mark.parametrize("known", [(0.0, 0.0, 0.0, 0.0), (-0.003, 0.054, -0.052, 0.011)])
def test_powers_come_on_top_of_those_of_a_known_fisheye(known):
    geometry = replace(GEOMETRY, focal_length_px=60.0, lens=Lens("kannala-brandt", known))
    matrix = np.array([[60.0, 0, CX], [0, 60.0, CY], [0, 0, 1]])
    more = {"k1": 0.02, "k2": -0.01, "k3": 0.002, "k4": -0.001}
    pixels = np.stack([X[::9, ::9].ravel(), Y[::9, ::9].ravel()], axis=1)[:, None]
    real = np.add(known, [*more.values()])
    flat = cv2.fisheye.undistortPoints(pixels, matrix, real)
    expected = cv2.fisheye.distortPoints(flat, matrix, np.array(known))[:, 0]
    effect = LensDistortion(LensDistortion.Config(model="fisheye", **more))
    found = effect.source_at(*pixels[:, 0].T, geometry=geometry)
    np.testing.assert_allclose(np.column_stack(found), expected, atol=2e-3)


def test_a_fisheye_has_no_tangential_coefficients():
    with pytest.raises(ValidationError, match="no tangential coefficients"):
        LensDistortion.Config(model="fisheye", p1=0.01)
    with pytest.raises(ValidationError, match="no coefficient k4"):
        LensDistortion.Config(k4=0.01)


def test_in_a_crop_the_lens_is_that_of_the_whole_image():
    crop = GEOMETRY.crop(x=40, y=20, width_px=50, height_px=40)
    whole = run(LensDistortion, light(), k1=-0.1)
    part = run(LensDistortion, light()[:, 20:60, 40:90], k1=-0.1, geometry=crop)
    np.testing.assert_allclose(part[INSIDE], whole[:, 20:60, 40:90][INSIDE], atol=1e-3)


def test_truth_moves_with_the_pixels():
    capture = sample_capture(frames=2)
    marked = np.where(capture.views[0].object_id == 1, 50.0, 1.0)[..., None] * np.ones(3)
    view = capture.views[0]
    depth = np.where(view.object_id == 1, 1.0, 4.0)
    capture = Capture(
        capture.episode, (View(view.camera, view.world_from_camera, marked, depth, view.object_id),)
    )
    for effect, settings in [
        (LensDistortion, {"k1": -0.3}),
        (FocalLengthError, {"scale": 1.3, "dx_px": 3.5}),
        (PoseError, {"rz": 10.0, "ry": 3.0}),
    ]:
        moved = applied(effect, capture, **settings).views[0]
        assert (moved.object_id != view.object_id).any()
        # Where light says sign, ids and depth do too, but for the pixels its edge runs through.
        assert ((moved.luminance_cd_m2[..., 0] > 25) == (moved.object_id == 1)).mean() > 0.99
        if effect is not PoseError:
            np.testing.assert_array_equal(moved.depth_m, np.where(moved.object_id == 1, 1.0, 4.0))
        else:
            assert set(np.unique(moved.depth_m < 2.5)) == {False, True}
        np.testing.assert_array_equal(moved.world_from_camera, view.world_from_camera)


@pytest.mark.parametrize(("channel", "constant", "square"), [(0, 0.01, -0.004), (2, -0.008, 0.006)])
def test_a_colour_is_magnified_by_its_polynomial(channel, constant, square):
    name = "red" if channel == 0 else "blue"
    found = run(LateralChromaticAberration, light(), **{name: constant, f"{name}_r2": square})

    # A point of the scene, followed forward: seen at radius R it now lies at R (1 + c + b r^2).
    def scene_at(x, y):
        dx, dy = x - CX, y - CY
        here = np.ones_like(dx)
        for _ in range(30):
            here = 1 / (1 + constant + square * (np.hypot(dx, dy) * here / GEOMETRY.half_diagonal_px) ** 2)
        return pattern(CX + dx * here, CY + dy * here)

    np.testing.assert_allclose(found[INSIDE][..., channel], light(scene_at)[INSIDE][..., 0], atol=0.02)
    np.testing.assert_array_equal(found[..., 1], light()[..., 1])
    np.testing.assert_array_equal(found[..., 2 - channel], light()[..., 2 - channel])


def test_mono_light_has_no_fringes():
    mono = light(channels=1)
    assert run(LateralChromaticAberration, mono, red=0.01) is mono


def test_a_turned_camera_sees_the_scene_through_opencvs_homography():
    found = run(PoseError, light(), rx=1.0, ry=-2.0, rz=3.0)
    turn, _ = cv2.Rodrigues(np.radians([1.0, -2.0, 3.0]))
    seen = cv2.perspectiveTransform(
        np.stack([X.ravel(), Y.ravel()], axis=1)[:, None], K @ turn @ np.linalg.inv(K)
    )[:, 0]
    expected = pattern(seen[:, 0], seen[:, 1]).reshape(X.shape)
    np.testing.assert_allclose(found[0, :, :, 0][INSIDE[1:]], expected[INSIDE[1:]], atol=0.02)


def test_above_zero_a_camera_looks_up_right_and_rolls_clockwise():
    spot = np.zeros((1, 72, 96, 1))
    spot[0, 37, 46] = 1.0

    def moved_to(**turn):
        row, column = np.unravel_index(run(PoseError, spot, **turn)[0, :, :, 0].argmax(), (72, 96))
        return row, column

    assert moved_to(rx=5.0)[0] > 37  # looking up, things sink
    assert moved_to(ry=5.0)[1] < 46
    spot = np.zeros((1, 72, 96, 1))
    spot[0, 37, 66] = 1.0
    assert moved_to(rz=30.0)[0] < 37  # rolled clockwise, things turn the other way


def test_a_shift_moves_near_things_more():
    depth = np.where(X < 48, 1.0, 4.0)
    found = run(PoseError, light(), tx=25.0, context=ImageContext(depth_m=depth))[0, :, :, 0]
    near, far = F * 0.025 / 1.0, F * 0.025 / 4.0  # 2 px and 0.5 px to the left
    np.testing.assert_allclose(found[20:50, 15:35], pattern(X + near, Y)[20:50, 15:35], atol=0.02)
    np.testing.assert_allclose(found[20:50, 60:80], pattern(X + far, Y)[20:50, 60:80], atol=0.02)


def test_depth_is_measured_from_the_real_camera():
    capture = sample_capture(frames=1)
    moved = applied(PoseError, capture, tz=500.0).views[0]
    np.testing.assert_allclose(moved.depth_m, 2.5, rtol=1e-6)


def test_without_depth_a_shift_is_refused_and_a_turn_is_not():
    with pytest.raises(ContextMissing, match="needs the depth"):
        run(PoseError, light(), tx=10.0)
    assert run(PoseError, light(), rx=1.0).shape == light().shape


def test_rows_are_sheared_by_constant_motion():
    context = ImageContext(velocity_px_s=np.array([300.0, 0.0]), reference_row=10)
    found = run(RollingShutter, light(), row_time_us=200.0, context=context)
    late_px = (Y - 10) * 200e-6 * 300
    expected = light(lambda x, y: pattern(x - (y - 10) * 0.06, y))
    inside = (late_px > 0) & (late_px + 8 < X) & (X < 88)
    np.testing.assert_allclose(found[0, inside, 0], expected[0, inside, 0], atol=0.02)


def test_motion_along_the_columns_stretches():
    context = ImageContext(velocity_px_s=np.array([0.0, 500.0]), reference_row=36)
    found = run(RollingShutter, light(), row_time_us=200.0, context=context)
    # y' = y + v t (y' - 36) gives the row a line is seen in.
    expected = light(lambda x, y: pattern(x, y - 0.1 * (y - 36)))
    np.testing.assert_allclose(found[INSIDE], expected[INSIDE], atol=0.02)


def test_rows_of_a_capture_show_the_scene_from_where_the_camera_was():
    """A camera that turns sees a scene at infinity: each row against the exact turn at its moment."""
    camera = Camera("c", 96, 72, pixel_um=3.0, focal_length_mm=0.24)
    rate = 1.5  # rad/s about the camera's y axis
    times = np.linspace(-1, 1, 401)
    poses = np.tile(np.eye(4), (401, 1, 1))
    poses[:, 0, 0] = poses[:, 2, 2] = np.cos(rate * times)
    poses[:, 0, 2], poses[:, 2, 0] = np.sin(rate * times), -np.sin(rate * times)
    rays = pixel_rays(camera)

    def seen(t):
        turn = np.array(
            [[np.cos(rate * t), 0, np.sin(rate * t)], [0, 1, 0], [-np.sin(rate * t), 0, np.cos(rate * t)]]
        )
        directions = rays @ turn.T
        return 5 + np.sin(30 * directions[..., 0] / directions[..., 2])

    far = np.full((1, 72, 96), np.inf)
    shown = np.repeat(seen(0.0)[None, ..., None], 3, axis=-1)
    episode = Episode(sample_world(), Trajectory(times, poses), np.array([0.0]), np.zeros(1))
    capture = Capture(episode, (View(camera, np.eye(4)[None], shown, far, np.zeros((1, 72, 96))),))
    rolled = applied(RollingShutter, capture, row_time_us=400.0).views[0].luminance_cd_m2[0, ..., 0]
    for row in (10, 36, 60):
        exact = seen((row - 35.5) * 400e-6)[row]
        np.testing.assert_allclose(rolled[row, 10:-10], exact[10:-10], atol=0.03)


def test_without_velocity_rolling_is_refused():
    with pytest.raises(ContextMissing, match="velocity"):
        run(RollingShutter, light(), row_time_us=10.0)
