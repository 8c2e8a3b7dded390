"""The line through levels that are made up: against numpy's polynomials, and by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from tacos_plugins.noise_calibration.levels import Levels
from tacos_plugins.noise_calibration.photon_transfer import CLIPPED_SHARE, ROUNDING_DN2, AffineFit, fit_affine

BLACK_DN = 20.0
PHOTON_DN, THERMAL_DN2 = 0.24, 1.8
ALTERNATING = 0.05 * np.array([1.0, -1.0] * 8)
"""Scatter of levels whose errors are a hundredth: a reduced chi square far above 1."""


def levels(signal_dn, *, bend_per_dn: float = 0.0, scatter=0.0) -> Levels:
    """Levels on a parabola, each known to a hundredth."""
    signal = np.asarray(signal_dn, np.float64)
    variance = PHOTON_DN * signal + THERMAL_DN2 + bend_per_dn * signal**2
    variance = variance * (1 + scatter) + ROUNDING_DN2
    return Levels(
        mean_dn=signal + BLACK_DN,
        variance_dn2=variance,
        error_dn2=0.01 * variance,
        fixed_dn2=np.zeros_like(signal),
        pixels=np.full(len(signal), 1000),
        clipped=np.zeros_like(signal),
        edge_excess=1.0,
        outliers=0,
        frames=8,
    )


def fitted(measured: Levels) -> AffineFit:
    return fit_affine(measured, black_level_dn=BLACK_DN)


def polynomial(measured: Levels, fit: AffineFit, degree: int, *, scaled: bool):
    """Coefficients from the constant up and their covariance, with the weights that the fit itself implies.

    `scaled`: widened by the reduced chi square.
    """
    signal = measured.mean_dn - BLACK_DN
    relative = measured.error_dn2 / measured.variance_dn2
    model = fit.variance_dn2(signal)
    for _ in range(20):
        found, covariance = np.polyfit(
            signal,
            measured.variance_dn2 - ROUNDING_DN2,
            degree,
            w=1 / (relative * model),
            cov=True if scaled else "unscaled",
        )
        model = np.polyval(found, signal) + ROUNDING_DN2
    return found[::-1], covariance[::-1, ::-1]


@pytest.mark.parametrize(("scatter", "scaled"), [(0.0, False), (0.001, False), (0.05, True)])
@pytest.mark.parametrize("count", [3, 6, 16])
def test_intervals_are_students_and_widen_where_levels_scatter_more_than_chance_allows(
    count, scatter, scaled
):
    measured = levels(np.linspace(10, 200, count), scatter=scatter / 0.05 * ALTERNATING[:count])
    fit = fitted(measured)
    line, covariance = polynomial(measured, fit, 1, scaled=scaled)
    assert (fit.thermal_dn2, fit.photon_dn) == pytest.approx(tuple(line), rel=1e-4)
    reach = stats.t(count - 2).ppf(0.975) * np.sqrt(np.diag(covariance))
    half_widths = [(high - low) / 2 for low, high in (fit.thermal_ci, fit.photon_ci)]
    assert half_widths == pytest.approx(list(reach), rel=1e-3)
    assert np.mean(fit.photon_ci) == pytest.approx(fit.photon_dn)
    assert np.mean(fit.thermal_ci) == pytest.approx(fit.thermal_dn2)
    assert (fit.misfit > 1) is scaled


def test_the_misfit_is_the_chi_square_per_degree_of_freedom():
    measured = levels(np.linspace(10, 200, 16), scatter=ALTERNATING)
    fit = fitted(measured)
    model = fit.variance_dn2(measured.mean_dn - BLACK_DN)
    chi_square = np.sum(((measured.variance_dn2 - model) / (0.01 * model)) ** 2)
    assert fit.misfit == pytest.approx(chi_square / 14, rel=1e-3)


@pytest.mark.parametrize(("scatter", "scaled"), [(0.0, False), (0.05, True)])
@pytest.mark.parametrize("bend_per_dn", [4e-4, -4e-4])
def test_the_bend_is_what_a_parabola_adds_at_the_top_in_shares_and_in_standard_errors(
    bend_per_dn, scatter, scaled
):
    measured = levels(np.linspace(10, 200, 16), bend_per_dn=bend_per_dn, scatter=scatter / 0.05 * ALTERNATING)
    fit = fitted(measured)
    parabola, covariance = polynomial(measured, fit, 2, scaled=scaled)
    line_at_top = fit.photon_dn * 200 + fit.thermal_dn2
    assert fit.bend == pytest.approx(parabola[2] * 200**2 / line_at_top, rel=1e-3)
    assert fit.bend_z == pytest.approx(parabola[2] / np.sqrt(covariance[2, 2]), rel=1e-3)


def test_a_parabola_takes_more_levels_than_a_line():
    three, four, five = (fitted(levels(np.linspace(10, 200, n), bend_per_dn=4e-4)) for n in (3, 4, 5))
    assert (three.bend, three.bend_z) == (four.bend, four.bend_z) == (0.0, 0.0)
    assert five.bend > 0.1
    assert five.bend_z > 1


def test_levels_that_are_censored_or_too_quiet_do_not_count():
    measured = levels(np.linspace(10, 200, 8))
    clipped = np.array([0.5, CLIPPED_SHARE, 0, 0, 0, 0, 0.9 * CLIPPED_SHARE, 1.1 * CLIPPED_SHARE])
    variance = measured.variance_dn2.copy()
    variance[3], variance[4] = 0.25 + ROUNDING_DN2, 0.3
    fit = fitted(replace(measured, clipped=clipped, variance_dn2=variance))
    assert fit.used.tolist() == [False, True, True, True, False, True, True, False]


@pytest.mark.parametrize("count", [5, 12])
def test_levels_near_a_full_well_do_not_count(count):
    """The variance is greatest at a signal of 200; levels count below nine tenths of that."""
    signal = np.array([*np.linspace(20, 160, count - 4), 175.0, 182.0, 200.0, 210.0])
    measured = levels(signal)
    variance = measured.variance_dn2.copy()
    variance[-1] = 0.6 * variance[-2]
    censored = replace(measured, variance_dn2=variance)
    if count == 5:
        with pytest.raises(ValueError, match="2 usable levels"):
            fitted(censored)
        return
    fit = fitted(censored)
    assert fit.saturation_dn == BLACK_DN + 200
    assert fit.used.tolist() == [True] * (count - 3) + [False] * 3
    assert fit.photon_dn == pytest.approx(PHOTON_DN)
    one_clipped = censored.clipped.copy()
    one_clipped[2] = 1.0
    assert not fitted(replace(censored, clipped=one_clipped)).used[2]


def test_too_few_levels_for_a_full_well_show_none():
    measured = levels([20, 100, 180, 200])
    variance = measured.variance_dn2.copy()
    variance[-1] *= 0.5
    assert fitted(replace(measured, variance_dn2=variance)).saturation_dn is None


@pytest.mark.parametrize("spread", [0.95, 1.05])
def test_a_line_takes_levels_farther_apart_than_three_times_their_noise(spread):
    brightest = 100.0
    reach = spread * 3 * np.sqrt(PHOTON_DN * brightest + THERMAL_DN2)
    measured = levels(np.linspace(brightest - reach, brightest, 6))
    if spread < 1:
        with pytest.raises(ValueError, match=r"^all usable levels are about equally bright$"):
            fitted(measured)
    else:
        assert fitted(measured).photon_dn == pytest.approx(PHOTON_DN)


def test_the_variance_of_a_fit_is_its_line_and_the_rounding():
    fit = fitted(levels(np.linspace(10, 200, 6)))
    expected = [THERMAL_DN2 + 1 / 12, PHOTON_DN * 50 + THERMAL_DN2 + 1 / 12]
    assert fit.variance_dn2(np.array([0.0, 50.0])).tolist() == pytest.approx(expected)
