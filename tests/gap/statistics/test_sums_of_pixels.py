"""Sums and masks of pixels, against the plain way to write them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_gap.statistics import Sample
from tacos_gap.statistics.codes import _looked_at
from tacos_gap.statistics.grid import tiles
from tacos_gap.statistics.masked import only_in
from tacos_gap.statistics.steady_light import in_steady_light
from tests.gap.small_captures import BLACK_DN, HEIGHT, WIDTH, capture


@given(seed=st.integers(0, 2**32), channels=st.sampled_from([1, 3]), frames=st.sampled_from([None, 2]))
def test_a_mask_leaves_what_counts_and_nothing_else(seed, channels, frames):
    rng = np.random.default_rng(seed)
    where = rng.random((7, 5)) > 0.4
    image = rng.random((*([frames] if frames else []), 7, 5, channels)).astype(np.float32)
    np.testing.assert_array_equal(only_in(where, image), image * where[..., None])


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_means_in_bins_are_those_of_their_pixels(dtype):
    bins = tiles(capture("flat", "flat", 100.0))
    image = np.random.default_rng(3).random((*bins.index.shape, 3)).astype(dtype)[..., 1]
    wanted = [image[bins.index == number].mean(dtype=np.float64) for number in range(len(bins.at))]
    np.testing.assert_allclose(bins.mean(image), wanted, rtol=1e-12)


def test_codes_are_those_of_pixels_that_count():
    of = capture("flat", "flat", 100.0, 2)
    of.valid[: len(of.valid) // 2] = False
    frames = np.where(of.valid[..., None], np.arange(of.real_dn.size).reshape(of.real_dn.shape), -1.0)
    seen = _looked_at(of, frames.astype(np.float32))
    assert seen.min() >= 0
    np.testing.assert_array_equal(seen, frames[:, of.valid].ravel())


@pytest.mark.parametrize(("count", "channels"), [(2, 3), (5, 1)])
def test_noise_is_what_pixels_in_steady_light_differ_from_their_mean_and_row_by(count, channels, monkeypatch):
    rng = np.random.default_rng(8)
    monkeypatch.setattr("tacos_gap.statistics.sampled.NOISE_SAMPLES", 10_000)
    of = capture("flat", "flat", 110.0, frames=count)
    shape = (count, HEIGHT, WIDTH, channels)
    lamp = rng.normal(1.0, 0.002, (count, 1, 1, 1))
    frames = np.rint(BLACK_DN + 100 * lamp + rng.normal(0, 3, shape)).astype(np.float32)
    sample = Sample(of, frames, np.full((1, *shape[1:]), 110.0, np.float32))
    assert 0 < sample.bands.size < HEIGHT
    steady = in_steady_light(of, frames, sample.light_of_frames)
    wanted = steady - frames.mean(axis=0)
    wanted = (wanted - wanted.mean(axis=2, keepdims=True)) * np.sqrt(
        count / (count - 1) * WIDTH / (WIDTH - 1)
    )
    np.testing.assert_allclose(sample.temporal, wanted[:, sample.bands.ravel()], atol=2e-4)
