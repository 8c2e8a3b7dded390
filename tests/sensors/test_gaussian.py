"""Standard normal numbers by inversion: beside numpy's, whose method is another."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from tacos_plugins.sensors.gaussian import BITS, PLACES, TAIL_BINS, TAIL_BITS, NormalNumbers, quantiles
from tacos_plugins.sensors.sample_loops import find_tails


@pytest.fixture(scope="module")
def drawn() -> np.ndarray:
    out = np.empty(4_000_000, np.float32)
    NormalNumbers(np.random.default_rng(11)).fill(out)
    return out


def test_the_distribution_is_the_normal(drawn):
    assert stats.kstest(drawn[:1_000_000], "norm").pvalue > 1e-3
    edges = np.concatenate([[-np.inf], np.linspace(-5, 5, 41), [np.inf]])
    counts = np.histogram(drawn, edges)[0]
    wanted = np.diff(stats.norm.cdf(edges)) * len(drawn)
    assert stats.chisquare(counts, wanted * counts.sum() / wanted.sum()).pvalue > 1e-3


@pytest.mark.parametrize("sigmas", [3.0, 3.5, 4.0, 4.5, 5.0])
def test_tails_are_as_long_as_they_should_be(drawn, sigmas):
    wanted = 2 * stats.norm.sf(sigmas) * len(drawn)
    found = np.count_nonzero(np.abs(drawn) > sigmas)
    assert abs(found - wanted) < 4 * np.sqrt(wanted) + 1


def test_moments(drawn):
    for order, wanted, spread in ((1, 0, 1), (2, 1, 2), (3, 0, 15), (4, 3, 96)):
        assert abs(np.mean(drawn.astype(np.float64) ** order) - wanted) < 4 * np.sqrt(spread / len(drawn))


def test_numbers_do_not_depend_on_one_another(drawn):
    for lag in (1, 2, 3, 12_000):
        assert abs(np.mean(drawn[lag:] * drawn[:-lag], dtype=np.float64)) < 4 / np.sqrt(len(drawn))


def test_bins_are_narrow_where_they_are_looked_up():
    table = quantiles().astype(np.float64)
    inner = table[TAIL_BINS:-TAIL_BINS]
    assert np.diff(table).min() > 0
    assert np.diff(inner).max() < 0.005
    np.testing.assert_allclose(
        inner, stats.norm.ppf((np.arange(1 << 16) + 0.5) / (1 << 16))[TAIL_BINS:-TAIL_BINS], atol=3e-5
    )
    np.testing.assert_array_equal(table, -table[::-1])
    assert np.mean(table**2) == pytest.approx(1, abs=1e-6)


@given(seed=st.integers(0, 2**32), cuts=st.lists(st.integers(0, 60), max_size=4), count=st.integers(0, 1000))
def test_numbers_do_not_depend_on_how_a_frame_is_cut(seed, cuts, count):
    whole, parts = np.empty(count, np.float32), np.empty(count, np.float32)
    NormalNumbers(np.random.default_rng(seed)).fill(whole)
    in_parts = NormalNumbers(np.random.default_rng(seed))
    for part in np.split(parts, np.minimum(np.array(sorted(cuts), int) * PLACES, count)):
        if len(part):
            in_parts.fill(part)
    np.testing.assert_array_equal(whole, parts)


def test_any_sample_can_be_drawn_alone():
    found = np.empty(4000, np.float32)
    NormalNumbers(np.random.default_rng(5)).fill(found)
    key = np.random.default_rng(5).integers(0, 1 << 64, (2, 2), np.uint64)[0]
    for place in (0, 5, 16, 1234, 3999):
        (word,) = np.random.Philox(key=key).advance(place // PLACES).random_raw(4)[place % PLACES // 4 :][:1]
        number = int(word) >> (place % 4 * BITS) & ((1 << BITS) - 1)
        if TAIL_BINS <= number < (1 << BITS) - TAIL_BINS:
            assert found[place] == quantiles()[number]


edges_of_bins = st.sampled_from(
    [0, TAIL_BINS - 1, TAIL_BINS, 2**BITS - TAIL_BINS - 1, 2**BITS - TAIL_BINS, 2**BITS - 1]
)


@given(places=st.lists(edges_of_bins | st.integers(0, 2**BITS - 1), min_size=1, max_size=40))
def test_tails_are_found_wherever_they_are(places):
    bins = np.array(places, np.uint16)
    words = np.concatenate([bins, np.zeros(-len(bins) % 4, np.uint16)]).view(np.uint64)
    tail = np.empty(len(bins), np.int64)
    found = tail[: find_tails(words, TAIL_BITS, len(bins), tail)]
    np.testing.assert_array_equal(found, np.flatnonzero((bins < TAIL_BINS) | (bins >= 2**BITS - TAIL_BINS)))


def test_only_the_end_of_a_frame_may_lie_within_a_counter():
    numbers = NormalNumbers(np.random.default_rng(1))
    numbers.fill(np.empty(PLACES + 1, np.float32))
    with pytest.raises(ValueError, match="multiple of 16"):
        numbers.fill(np.empty(1, np.float32))
