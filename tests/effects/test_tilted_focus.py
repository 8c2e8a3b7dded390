"""Focus that changes over the field, as where a sensor is tilted against its lens."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage
from scipy.special import j1

from tacos_framework import Plugins
from tacos_framework.values import ImageGeometry
from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.captures import CaptureFolder, RealCapture
from tacos_gap.hypotheses.candidates import candidates
from tacos_plugins.effects.blur import blur, gaussian_kernel
from tacos_plugins.effects.defocus import Defocus
from tacos_plugins.effects.field_blur import blur_over_field
from tacos_plugins.effects.focus_plane import tilted_plane
from tests.effects.light_arrays import GEOMETRY, light, run
from tests.gap.small_captures import BLACK_DN, capture

WIDTH, HEIGHT = 320, 240


def texture(seed: int = 3) -> NDArray[np.float64]:
    """(H, W) a picture with detail of all sizes, as things have [DN]."""
    white = np.fft.rfft2(np.random.default_rng(seed).normal(size=(HEIGHT, WIDTH)))
    frequency = np.hypot(np.fft.fftfreq(HEIGHT)[:, None], np.fft.rfftfreq(WIDTH)[None, :])
    image = np.fft.irfft2(white / np.maximum(frequency, 0.01) ** 0.8, s=(HEIGHT, WIDTH))
    return BLACK_DN + np.clip(110 + 35 * image / image.std(), 10, 230)


def out_of_focus(image: NDArray[np.float64], radii_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Each column a mean over its own disc, of pixels split in 9 x 9 (scipy)."""
    blurred = np.empty_like(image)
    fine = (np.arange(25 * 9) - 112) / 9
    for radius in np.unique(radii_px.round(1)):
        inside = np.hypot(fine[:, None], fine[None, :]) <= max(radius, 0.05)
        kernel = inside.reshape(25, 9, 25, 9).sum(axis=(1, 3)).astype(float)
        whole = ndimage.convolve(image, kernel / kernel.sum(), mode="nearest")
        blurred[:, radii_px.round(1) == radius] = whole[:, radii_px.round(1) == radius]
    return blurred


def scene(real: NDArray[np.float64], expected: NDArray[np.float64]) -> RealCapture:
    """Two frames with the noise that captures declare."""
    noise = np.random.default_rng(8).normal(0, np.sqrt(0.24 * (real - BLACK_DN) + 1.8), (2, HEIGHT, WIDTH))
    return replace(
        capture("scene", "scene", BLACK_DN),
        real_dn=np.clip(np.round(real + noise), 0, 255).astype(np.float32)[..., None],
        expected_dn=expected.astype(np.float32)[None, ..., None],
        valid=np.ones((HEIGHT, WIDTH), bool),
        geometry=ImageGeometry(WIDTH, HEIGHT, 400.0, ((WIDTH - 1) / 2, (HEIGHT - 1) / 2), 3.0),
    )


COLUMNS = np.arange(WIDTH) - (WIDTH - 1) / 2
TILTED = np.abs(1.5 + 0.02 * COLUMNS)
"""Radius of each column [px]: sharp a quarter of the way to the left, 4.7 px at the right edge."""


def test_the_radius_grows_along_a_line_and_through_sharpness():
    before = light(lambda x, y: 3 + np.cos(2 * np.pi * 0.125 * y), channels=1)
    after = run(Defocus, before, radius_px=1.0, slope_x=0.05)
    radius = np.abs(1.0 + 0.05 * GEOMETRY.x_px[0])
    z = np.maximum(2 * np.pi * radius * 0.125, 1e-9)
    wave = before[0, 8:-8, :, 0] - 3
    found = ((after[0, 8:-8, :, 0] - 3) * wave).sum(axis=0) / (wave**2).sum(axis=0)
    np.testing.assert_allclose(found, 2 * j1(z) / z, atol=0.03)


def test_it_is_the_same_in_a_crop_and_leaves_even_light_as_it_is():
    before = light(lambda x, y: 3 + np.cos(0.7 * x) * np.cos(0.5 * y), channels=1)
    crop = GEOMETRY.crop(x=40, y=20, width_px=50, height_px=40)
    settings = {"radius_px": 0.5, "slope_x": 0.02, "slope_y": -0.03}
    whole = run(Defocus, before, **settings)
    part = run(Defocus, before[:, 20:60, 40:90], geometry=crop, **settings)
    np.testing.assert_allclose(part[:, 8:-8, 8:-8], whole[:, 28:52, 48:82], atol=0.02)
    np.testing.assert_allclose(run(Defocus, np.full_like(before, 5.0), **settings), 5.0, rtol=1e-6)


def test_blurs_are_mixed_as_if_each_had_been_made_of_the_whole_frame():
    image = np.random.default_rng(1).uniform(0, 10, (1, 60, 80, 1))
    width = np.broadcast_to(np.linspace(0.5, 2.0, 80), (60, 80))
    found = blur_over_field(image, width, gaussian_kernel)
    steps = np.geomspace(0.25, 4.0, 11)
    wanted = np.zeros_like(image)
    for i, step in enumerate(steps):
        share = np.interp(width**2, steps, np.eye(len(steps))[i])[..., None]
        wanted += share * blur(image, gaussian_kernel(float(np.sqrt(step))))
    np.testing.assert_allclose(found, wanted, atol=1e-6)


def test_the_plane_of_focus_is_read_off_a_picture():
    sharp = texture()
    plane = tilted_plane(scene(out_of_focus(sharp, TILTED), sharp))
    assert plane is not None
    assert plane.radius_px == pytest.approx(1.5, abs=0.3)
    assert (plane.slope_x, plane.slope_y) == pytest.approx((0.02, 0.0), abs=0.003)


@pytest.mark.parametrize("radius_px", [0.0, 3.0])
def test_focus_alike_all_over_is_no_tilt(radius_px):
    sharp = texture()
    even = out_of_focus(sharp, np.full(WIDTH, radius_px))
    assert tilted_plane(scene(even, sharp)) is None


def test_a_tilted_focus_is_named_with_its_slope():
    sharp = texture()
    pictures = CaptureFolder(Path("captures"), (scene(out_of_focus(sharp, TILTED), sharp),))
    found = diagnose(pictures, candidates(Plugins.discover()))
    cause = found.causes[0]
    assert (found.verdict, cause.effect) == ("explained", "defocus")
    assert cause.parameters["slope_x"].value == pytest.approx(0.02, rel=0.1)
    assert cause.parameters["radius_px"].value == pytest.approx(1.5, rel=0.1)
