"""Standard normal numbers by inversion: beside numpy's, whose method is another."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from tacos_plugins.sensors.gaussian import TAIL_BINS, fill_normal, quantiles


@pytest.fixture(scope="module")
def drawn() -> np.ndarray:
    out = np.empty(4_000_000, np.float32)
    fill_normal(out, np.random.default_rng(11))
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
