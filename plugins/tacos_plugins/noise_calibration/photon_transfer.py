"""The photon transfer curve: a straight line of variance over mean, through levels of brightness.

Each level (`tacos_plugins.noise_calibration.levels`) is weighed by how well its variance is known:

    var = s_p (mean - black) + s_t + 1/12          (paper, supplement, Sec. Noise Model Calibration)

where 1/12 DN^2 is the share of rounding, which a simulated camera adds by itself.

Source: EMVA Standard 1288, Release 4.0, Sec. 6; Janesick 2007, "Photon Transfer".
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from tacos_plugins.noise_calibration.levels import Levels

ROUNDING_DN2 = 1 / 12
"""Variance of the error of rounding to whole numbers [DN^2]."""

FINEST_DN2 = 0.25 + ROUNDING_DN2
"""Below this variance rounding hides part of the noise rather than adding to it [DN^2]."""

CLIPPED_SHARE = 1e-3
"""Share of samples at either end of the range from which a level counts as censored [1]."""


@dataclass(frozen=True, eq=False)
class AffineFit:
    """A line through the levels of a channel, with 95 % confidence intervals."""

    photon_dn: float
    photon_ci: tuple[float, float]
    """Slope s_p and its interval [DN]."""
    thermal_dn2: float
    thermal_ci: tuple[float, float]
    """Variance without signal s_t, rounding taken off, and its interval [DN^2]."""
    used: NDArray[np.bool_]
    """(L,) which levels the line rests on."""
    misfit: float
    """Reduced chi square: 1 where the line explains all but chance [1]."""
    bend: float
    """Departure of a parabola from the line at the brightest level used, relative to its variance [1]."""
    bend_z: float
    """The same in standard errors [1]."""
    saturation_dn: float | None
    """Mean at which the variance collapses below the white level; None where it does not [DN]."""

    def variance_dn2(self, signal_dn: NDArray[np.float64]) -> NDArray[np.float64]:
        """Variance on a signal above black, rounding included [DN^2]."""
        return self.photon_dn * signal_dn + self.thermal_dn2 + ROUNDING_DN2


def fit_affine(levels: Levels, *, black_level_dn: float) -> AffineFit:
    """The line of variance over signal, by weighted least squares.

    Weights come from the line itself, in a few rounds: measured variances that chance made small would
    otherwise weigh too much and pull the line down. Levels that are censored at either end, that noise does
    not spread over whole numbers, or that lie beyond the point where photosites fill up, are left out.
    Intervals are widened where levels scatter more than chance allows.

    Raises `ValueError` when fewer than three levels are left, or they are all equally bright.
    """
    used = (levels.clipped <= CLIPPED_SHARE) & (levels.variance_dn2 >= FINEST_DN2)
    saturation_dn = _saturation_dn(levels, used)
    if saturation_dn is not None:
        used &= levels.mean_dn < 0.9 * (saturation_dn - black_level_dn) + black_level_dn
    if used.sum() < 3:
        raise ValueError(f"{used.sum()} usable levels, and a line with an error takes at least three")
    signal = levels.mean_dn[used] - black_level_dn
    variance = levels.variance_dn2[used] - ROUNDING_DN2
    if np.ptp(signal) < 3 * math.sqrt(variance.max()):
        raise ValueError("all usable levels are about equally bright")
    relative = levels.error_dn2[used] / levels.variance_dn2[used]
    line, covariance, misfit = _weighted_polynomial(signal, variance, relative, degree=1)
    widened = covariance * max(1.0, misfit)
    quantile = float(stats.t.ppf(0.975, used.sum() - 2))
    reach = quantile * np.sqrt(np.diag(widened))
    bend, bend_z = 0.0, 0.0
    if used.sum() > 4:
        parabola, curved, rest = _weighted_polynomial(signal, variance, relative, degree=2)
        top = signal[-1]
        bend = float(parabola[2] * top**2 / max(np.polyval(line[::-1], top), 1e-12))
        bend_z = float(parabola[2] / math.sqrt(curved[2, 2] * max(1.0, rest)))
    return AffineFit(
        photon_dn=float(line[1]),
        photon_ci=(float(line[1] - reach[1]), float(line[1] + reach[1])),
        thermal_dn2=float(line[0]),
        thermal_ci=(float(line[0] - reach[0]), float(line[0] + reach[0])),
        used=used,
        misfit=misfit,
        bend=bend,
        bend_z=bend_z,
        saturation_dn=saturation_dn,
    )


def _weighted_polynomial(
    x: NDArray[np.float64], y: NDArray[np.float64], relative_error: NDArray[np.float64], *, degree: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Coefficients from the constant up, their covariance, and the reduced chi square."""
    powers = np.vander(x, degree + 1, increasing=True)
    fitted = y
    for _ in range(6):
        error = relative_error * np.maximum(fitted + ROUNDING_DN2, FINEST_DN2)
        scaled = powers / error[:, None]
        covariance = np.asarray(np.linalg.inv(scaled.T @ scaled), dtype=np.float64)
        coefficients = covariance @ (scaled.T @ (y / error))
        fitted = powers @ coefficients
    freedom = max(len(x) - degree - 1, 1)
    return coefficients, covariance, float(np.sum(((y - fitted) / error) ** 2) / freedom)


def _saturation_dn(levels: Levels, used: NDArray[np.bool_]) -> float | None:
    """The mean at which variance turns down; the maximum of the photon transfer (EMVA 1288, Sec. 6.6)."""
    if used.sum() < 5:
        return None
    mean, variance = levels.mean_dn[used], levels.variance_dn2[used]
    top = int(np.argmax(variance))
    return float(mean[top]) if (variance[top:] < 0.7 * variance[top]).any() else None
