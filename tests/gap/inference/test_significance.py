"""p-values of statistics: uniform where nothing differs, small where one does."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import kstest

from tacos_gap.inference.significance import block_test, discoveries

COUNT = 40


def drawn(rng: np.random.Generator, blocks: np.ndarray, count: int) -> np.ndarray:
    """(count, K) noise whose numbers vary together within a block, as neighbouring tiles do."""
    shared = rng.normal(0, 0.3, (count, COUNT))[:, blocks]
    return np.asarray(shared + rng.normal(0, 0.5, (count, len(blocks))))


def family_p_value(seed: int, added: float = 0.0) -> float:
    rng = np.random.default_rng(seed)
    blocks = np.repeat(np.arange(COUNT), rng.integers(1, 60, COUNT))
    z = drawn(rng, blocks, 1)[0] + added * (blocks == 7)
    return block_test(z, drawn(rng, blocks, 16), blocks).family_p_value()


def test_p_values_of_a_folder_are_uniform_under_the_null():
    p_values = [family_p_value(seed) for seed in range(200)]
    assert kstest(p_values, "uniform").statistic < 0.12
    assert np.mean(np.array(p_values) < 0.05) <= 0.09


def test_one_statistic_that_differs_is_enough():
    assert all(family_p_value(seed, added=6.0) < 0.02 for seed in range(10))


def test_fewer_statistics_make_the_same_one_less_of_a_coincidence():
    rng = np.random.default_rng(3)
    blocks = np.repeat(np.arange(COUNT), 12)
    z = drawn(rng, blocks, 1)[0] + 1.0 * (blocks == 7)
    test = block_test(z, drawn(rng, blocks, 16), blocks)
    assert test.family_p_value(np.arange(COUNT) == 7) < test.family_p_value()


def test_captures_without_any_noise_give_no_division_by_zero():
    blocks = np.repeat(np.arange(3), 4)
    test = block_test(np.zeros(12), np.zeros((16, 12)), blocks)
    assert np.isfinite(test.p_values).all()
    assert test.family_p_value() > 0.2


def test_discoveries_are_those_of_benjamini_and_hochberg():
    # their example (1995, section 3.2), at q = .05: four of fifteen
    small = [0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298, 0.0344, 0.0459]
    p_values = np.array([*small, 0.3240, 0.4262, 0.5719, 0.6528, 0.7590, 1.000])
    assert discoveries(p_values, 0.05).sum() == pytest.approx(4)
