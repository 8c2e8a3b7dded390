"""Noise of a camera at gains where it was not measured."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_validation.noise.two_stage_noise import (
    INTERCEPT_DEPARTURE,
    SLOPE_DEPARTURE,
    NoiseOverGain,
    fit_two_stages,
)

GAINS = 2.0 ** np.arange(8)


@given(before=st.floats(1e-12, 1e-8), after=st.floats(1e-10, 1e-6), slope=st.floats(1e-7, 1e-3))
def test_exact_chain_is_found_again_between_its_gains(before: float, after: float, slope: float) -> None:
    camera = NoiseOverGain(GAINS, slope * GAINS, before * GAINS**2 + after)
    noise = camera.at(11.0)
    assert noise.slope == pytest.approx(slope * 11, rel=1e-3)
    assert noise.intercept == pytest.approx(before * 121 + after, rel=0.15)


@given(unit=st.floats(0.01, 1000))
def test_unit_of_the_gain_does_not_matter(unit: float) -> None:
    slopes, intercepts = 1e-5 * GAINS**0.9, 2e-9 * GAINS**2 + 8e-9
    here = NoiseOverGain(GAINS, slopes, intercepts).at(5.0)
    there = NoiseOverGain(unit * GAINS, slopes, intercepts).at(unit * 5.0)
    assert there == pytest.approx(here, rel=1e-2)


def test_mode_of_conversion_gain_is_followed_near_measured_gains() -> None:
    """A photosite that switches at gain 8 has a third of the read noise from there on."""
    before = np.where(GAINS < 8, 9e-9, 1e-9)
    camera = NoiseOverGain(GAINS, 1e-5 * GAINS, before * GAINS**2)
    assert camera.at(3.0).intercept == pytest.approx(9e-9 * 9, rel=0.35)
    assert camera.at(50.0).intercept == pytest.approx(1e-9 * 2500, rel=0.35)


def test_prediction_far_away_is_as_uncertain_as_the_prior() -> None:
    noise = NoiseOverGain(GAINS, 1e-5 * GAINS, 1e-9 * GAINS**2).at(2.0**60)
    assert noise.slope_sd == pytest.approx(
        np.hypot(SLOPE_DEPARTURE.spread, SLOPE_DEPARTURE.scatter), rel=0.01
    )
    wide = np.hypot(INTERCEPT_DEPARTURE.spread, INTERCEPT_DEPARTURE.scatter)
    assert noise.intercept_sd == pytest.approx(wide, rel=0.01)


def test_intercept_below_zero_bears_on_the_slope_alone() -> None:
    good = NoiseOverGain(GAINS[:7], 1e-5 * GAINS[:7], 1e-9 * GAINS[:7] ** 2)
    failed = NoiseOverGain(GAINS, 1e-5 * GAINS, np.append(1e-9 * GAINS[:7] ** 2, -1.0))
    assert failed.at(100.0).intercept == pytest.approx(good.at(100.0).intercept)
    assert failed.at(100.0).slope_sd < good.at(100.0).slope_sd


@pytest.mark.parametrize(
    ("gains", "slopes", "intercepts"),
    [([], [], []), ([1.0], [1e-5], [-1.0]), ([0.0], [1e-5], [1e-9]), ([1.0], [0.0], [1e-9])],
)
def test_measurements_that_say_nothing_are_refused(
    gains: list[float], slopes: list[float], intercepts: list[float]
) -> None:
    with pytest.raises(ValueError, match="needs gains and slopes above 0"):
        NoiseOverGain(gains, slopes, intercepts)


def test_one_gain_gives_half_to_each_stage() -> None:
    before, after = fit_two_stages(np.array([4.0]), np.array([32.0]))
    assert (before * 16, after) == pytest.approx((16, 16))
