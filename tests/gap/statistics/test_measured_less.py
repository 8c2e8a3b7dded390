"""What is measured in fewer pixels, or not again, says the same."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tacos_framework.plugins import Plugins
from tacos_gap.captures import RealCapture
from tacos_gap.evidence import simulated_statistics
from tacos_gap.evidence.simulated_statistics import SimulatedStatistics
from tacos_gap.statistics import Sample, measure
from tacos_gap.statistics.grid import tile_means, tiles
from tacos_gap.statistics.line_means import line_means, over_channels, over_frames, over_image
from tacos_gap.statistics.sampled import BAND_ROWS, NOISE_SAMPLES, noise_bands, sampled
from tacos_plugins.sensors import kept_numbers
from tacos_plugins.sensors.gaussian import NormalNumbers
from tests.gap.taken import capture, effect, patchwork, taken


@given(st.integers(1, 6), st.integers(16, 3000), st.integers(16, 4000))
@settings(max_examples=60, deadline=None)
@example(frames=5, height=18, width=3277)
@example(frames=6, height=3000, width=4000)
def test_bands_of_rows_hold_enough_noise_and_lie_in_the_image(frames: int, height: int, width: int) -> None:
    bands = noise_bands((frames, height, width, 1))
    assert bands.min() == 0
    assert bands.max() >= height - 2
    assert len(np.unique(bands)) == bands.size, "no row counts twice"
    assert (np.diff(bands, axis=1) == 1).all()
    assert frames * bands.size * width >= min(NOISE_SAMPLES, frames * height * width)
    if len(bands) > 1:
        assert bands.shape[1] == BAND_ROWS
        assert (bands[:, 0] % 2 == 0).all(), "mosaics begin alike in each"


@given(st.integers(40, 900), st.integers(40, 900))
@settings(max_examples=20, deadline=None)
def test_samples_come_from_every_column(height: int, width: int) -> None:
    columns = np.broadcast_to(np.arange(width, dtype=np.float32)[None, :, None], (height, width, 3))
    chosen = sampled(np.ascontiguousarray(columns), 20 * width)
    assert len(np.unique(chosen)) == width


@given(st.integers(0, 99), st.sampled_from([1, 3]), st.integers(1, 4))
@settings(max_examples=20, deadline=None)
def test_products_of_matrices_are_means(seed: int, channels: int, count: int) -> None:
    frames = np.random.default_rng(seed).normal(50, 20, (count, 37, 53, channels)).astype(np.float32)
    image = frames[0]
    for found, truth in (
        (over_frames(frames), frames.mean(axis=0)),
        (over_channels(image), image.mean(axis=-1)),
        (over_image(image), image.mean(axis=(0, 1))),
        (line_means(image, 0), image.mean(axis=0)),
        (line_means(image, 1), image.mean(axis=1)),
        (line_means(image[::2, 3:], 1), image[::2, 3:].mean(axis=1)),
    ):
        np.testing.assert_allclose(found, truth, rtol=1e-4, atol=1e-3)


@pytest.mark.parametrize("masked", [False, True])
def test_means_of_tiles_are_those_counted_pixel_by_pixel(masked: bool) -> None:
    flat = capture("flat", 90.0, channels=3)
    if masked:
        flat.valid[:25, 30:90] = False
    image = np.random.default_rng(2).normal(5, 3, (*flat.valid.shape, 3)).astype(np.float32)
    counted = np.stack([tiles(flat).mean(image[..., channel]) for channel in range(3)], axis=1)
    np.testing.assert_allclose(tile_means(flat, image), counted, rtol=1e-4)


def noisy(plugins: Plugins, kind: str = "flat") -> RealCapture:
    (made,) = taken([capture(kind, 0.0 if kind == "dark" else patchwork())], [effect(plugins, "read-noise")])
    return made


def test_noise_of_bands_is_that_of_all_rows(plugins: Plugins, monkeypatch: pytest.MonkeyPatch) -> None:
    seen = noisy(plugins)
    assert seen.expected_dn is not None
    whole = {b.statistic: b for b in measure(Sample(seen, seen.real_dn, seen.expected_dn))}
    monkeypatch.setattr("tacos_gap.statistics.sampled.NOISE_SAMPLES", 20_000)
    part = {b.statistic: b for b in measure(Sample(seen, seen.real_dn, seen.expected_dn))}
    assert list(part) == list(whole)
    for name in ("photon_transfer", "noise_autocorrelation", "noise_tails", "noise_over_field"):
        assert part[name].at == whole[name].at
        assert not np.array_equal(part[name].values, whole[name].values)
        np.testing.assert_allclose(part[name].values, whole[name].values, atol=0.08)


def test_what_an_effect_leaves_as_it_is_is_not_measured_again(
    plugins: Plugins, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = noisy(plugins, "dark")
    simulations = SimulatedStatistics(seen, seen, seed=3)
    plain = simulations.of((), 0)
    measured: list[Any] = []
    monkeypatch.setattr(
        simulated_statistics, "measure", lambda sample: measured.append(sample) or measure(sample)
    )
    saturated = simulations.of([effect(plugins, "saturation", level_dn=200.0)], 0)
    assert not measured, "nothing in the dark saturates"
    np.testing.assert_array_equal(saturated, plain)
    lifted = simulations.of([effect(plugins, "black-level", offset_dn=3.0)], 0)
    assert len(measured) == 1
    assert not np.array_equal(lifted, plain)


def test_noise_that_hypotheses_share_is_drawn_once(plugins: Plugins, monkeypatch: pytest.MonkeyPatch) -> None:
    seen = noisy(plugins)
    drawn: list[bytes] = []

    class Counted(NormalNumbers):
        def fill(self, out: Any) -> None:
            drawn.append(self.key)
            super().fill(out)

    monkeypatch.setattr(kept_numbers, "NormalNumbers", Counted)
    simulations = SimulatedStatistics(seen, seen, seed=3)
    chain = [effect(plugins, "black-level", offset_dn=3.0)]
    found = [simulations.of((), 0), simulations.of(chain, 0), simulations.expecting(seen).of((), 0)]
    assert len(drawn) == seen.frames
    monkeypatch.setattr(simulated_statistics, "_NUMBERS_BYTES", 0)
    anew = SimulatedStatistics(seen, seen, seed=3)
    np.testing.assert_array_equal(found, [anew.of((), 0), anew.of(chain, 0), anew.of((), 0)])
    assert len(drawn) > seen.frames


def test_a_single_pixel_that_a_glimpse_misses_is_touched() -> None:
    even = np.full((1, 48, 64, 3), 90.0, np.float32)
    assert simulated_statistics._are_alike(even * np.float32(1 + 1e-7), even)
    spotted = even.copy()
    spotted[0, 20, 31, 1] += 0.01
    assert not simulated_statistics._are_alike(spotted, even)
