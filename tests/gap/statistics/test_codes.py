"""Statistics of codes where noise spreads values over few of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tacos_gap.captures import Noise
from tacos_gap.statistics import Sample, StatisticBlock
from tacos_gap.statistics.codes import PERIODS, code_statistics
from tests.gap.small_captures import HEIGHT, WIDTH, capture


def codes_of(level_dn: float, sigma_dn: float, step_dn: int = 1) -> dict[str, StatisticBlock]:
    """Of two frames of an even wall, rounded to steps of whole codes."""
    wall = replace(capture("flat", "flat", level_dn), noise=Noise((0.0,), (sigma_dn**2,)))
    noise = np.random.default_rng(0).normal(0, sigma_dn, (2, HEIGHT, WIDTH, 1))
    frames = (np.rint((level_dn + noise) / step_dn) * step_dn).astype(np.float32)
    assert wall.expected_dn is not None
    return {block.statistic: block for block in code_statistics(Sample(wall, frames, wall.expected_dn))}


@pytest.mark.parametrize("sigma_dn", [0.8, 1.3, 2.4, 5.0])
@pytest.mark.parametrize("level_dn", [100.0, 100.25, 100.5])
def test_a_comb_is_told_from_few_codes(sigma_dn: float, level_dn: float):
    """However few they are, and wherever the level lies between two codes."""
    every_code = codes_of(level_dn, sigma_dn)["code_comb"]
    every_second = codes_of(level_dn, sigma_dn, step_dn=2)["code_comb"]
    period_2 = PERIODS.index(2)
    assert every_code.values[period_2] < 0.1
    assert every_code.values[-1] == 0  # none is empty
    assert every_second.values[period_2] == pytest.approx(1.0)


def test_a_little_more_noise_is_no_other_comb():
    """A wall whose common codes are seven, and eight as soon as noise is a percent more."""
    steps = np.linspace(1.5, 2.2, 30)
    found = np.array([codes_of(100.3, sigma)["code_comb"].values for sigma in steps])
    assert np.abs(np.diff(found, axis=0)).max() < 0.02


def test_the_largest_codes_of_a_quiet_wall_are_no_pile():
    assert "top_level" not in codes_of(100.0, 0.8)
    assert "top_level" in codes_of(100.0, 4.0)
