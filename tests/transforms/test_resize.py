"""Resized images: the mean over areas, its noise, and the geometry that goes with it."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from tacos_framework.testing import TransformConformance
from tacos_framework.testing.samples import sample_capture, sample_frames, sample_rig
from tacos_framework.values import Camera, FrameBatch, Rig
from tacos_plugins.transforms.resize import Resize, averaged, resized_camera

RNG = np.random.default_rng(4)


class TestResize(TransformConformance):
    component = Resize
    config = {"factor": 0.5}  # noqa: RUF012


def resized(frames: FrameBatch, **config: float) -> FrameBatch:
    return Resize(Resize.Config(**config)).transform(frames)


@pytest.mark.parametrize("whole", [2, 3, 4])
def test_whole_factors_are_opencv_s_means_over_areas(whole: int) -> None:
    image = RNG.uniform(0, 255, (48, 96, 3)).astype(np.float32)
    size = (96 // whole, 48 // whole)
    expected = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    np.testing.assert_allclose(averaged(image[None], size[1], size[0], whole)[0], expected, atol=1e-3)


def test_other_factors_are_opencv_s_where_they_divide_the_image() -> None:
    image = RNG.uniform(0, 255, (60, 90, 3)).astype(np.float32)
    expected = cv2.resize(image, (36, 24), interpolation=cv2.INTER_AREA)
    np.testing.assert_allclose(averaged(image[None], 24, 36, 2.5)[0], expected, atol=1e-3)


@given(pixels=st.floats(1, 12), level=st.floats(1, 200))
def test_an_even_image_stays_as_bright(pixels: float, level: float) -> None:
    image = np.full((1, 31, 47, 1), level, np.float32)
    small = averaged(image, int(31 / pixels), int(47 / pixels), pixels)
    np.testing.assert_allclose(small, level, rtol=1e-5)


def test_independent_noise_falls_as_the_root_of_the_area() -> None:
    noise = RNG.normal(0, 10, (1, 600, 600, 1)).astype(np.float32)
    assert averaged(noise, 200, 200, 3.0).std() == pytest.approx(10 / 3, rel=0.02)


@given(
    pixels=st.floats(1, 6),
    x=st.floats(-0.5, 0.5),
    y=st.floats(-0.5, 0.5),
    shift=st.tuples(st.floats(-3, 3), st.floats(-3, 3)),
)
def test_a_point_lies_where_its_pixels_went(pixels, x, y, shift) -> None:
    """The old place of a point, taken to the new grid, is where the new camera images it."""
    camera = Camera("c", 64, 48, 3.0, 0.09, principal_point_px=(31.5 + shift[0], 23.5 + shift[1]))
    small = resized_camera(camera, pixels)
    point = np.array([x, y, 1.0])
    old, new = (camera.intrinsics @ point)[:2], (small.intrinsics @ point)[:2]
    size, count = np.array([64, 48]), np.array([small.width_px, small.height_px])
    np.testing.assert_allclose((old + 0.5 - (size - count * pixels) / 2) / pixels - 0.5, new, atol=1e-9)
    assert small.simulated_binning == pytest.approx(camera.simulated_binning)


def test_a_view_goes_with_its_frames() -> None:
    frames = sample_frames(sample_rig(width_px=64, height_px=48))
    small = resized(frames, factor=0.5)
    (view,), (image,) = small.capture.views, small.images
    assert image.shape == (*view.depth_m.shape, 3) == (6, 24, 32, 3)
    assert image.dtype == np.uint8
    assert set(np.unique(view.object_id)) == set(np.unique(frames.capture.views[0].object_id))
    expected = frames.images[0].reshape(6, 24, 2, 32, 2, 3).mean((2, 4))
    assert np.abs(image - expected).max() <= 0.5
    assert view.camera.focal_length_px == pytest.approx(frames.capture.views[0].camera.focal_length_px / 2)


def test_a_width_is_that_of_the_camera_s_own_images() -> None:
    whole = sample_rig(width_px=64, height_px=48).cameras[0]
    simulated = Rig((replace(whole, binning=4.0),))  # the camera has 256 x 192 pixels
    small = resized(FrameBatch(sample_capture(simulated), sample_frames(simulated).images), width_px=128)
    assert small.images[0].shape[1:3] == (24, 32)
    same = resized(sample_frames(sample_rig()), width_px=2000)
    np.testing.assert_array_equal(same.images[0], sample_frames(sample_rig()).images[0])


@pytest.mark.parametrize("config", [{}, {"factor": 0.5, "width_px": 10}])
def test_one_of_factor_and_width_is_given(config) -> None:
    with pytest.raises(ValidationError, match="give exactly one of factor and width_px"):
        Resize.Config(**config)
