"""Noise of frames of many megapixels, of which a part is looked at."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tacos_framework.values import ImageContext
from tacos_gap.captures.noise_estimate import ENOUGH_PIXELS, estimate_noise, thinned
from tests.gap.small_captures import capture


@pytest.mark.parametrize("size", [(1200, 1600), (1000, 4002), (2000, 999), (1601, 1003)])
def test_a_large_mosaic_is_thinned_to_all_of_its_colours_alike(size):
    rows, columns = np.indices(size)
    phases = thinned((2 * (rows % 2) + columns % 2)[..., None])
    counted = np.bincount(phases.ravel(), minlength=4)
    assert ENOUGH_PIXELS / 4 < phases.size <= ENOUGH_PIXELS
    assert counted.min() > 0.9 * counted.max()


def test_an_ordinary_frame_stays_as_it_is():
    frame = np.ones((2, 960, 1280, 3), np.float32)
    assert thinned(frame) is frame


@pytest.mark.parametrize("frames", [1, 2])
def test_the_noise_of_a_large_frame_is_that_of_a_small_one(frames):
    rng = np.random.default_rng(0)
    light = np.linspace(20, 200, 1700, dtype=np.float32)
    shape = (frames, 1100, 1700, 1)
    real = light[:, None] + rng.standard_normal(shape, np.float32) * np.sqrt(2 + 0.1 * light)[:, None]
    context = ImageContext(black_level_dn=0.0, white_level_dn=255.0)
    wall = replace(
        capture("wall", "flat", 0.0),
        real_dn=real,
        expected_dn=None,
        valid=np.ones(shape[1:3], bool),
        context=context,
    )
    noise = estimate_noise(wall)
    assert noise.photon_dn[0] == pytest.approx(0.1, rel=0.1)
    assert noise.thermal_dn2[0] == pytest.approx(2, rel=0.2)
