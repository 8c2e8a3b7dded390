"""Figures of the standard from levels: pure functions of arrays, evaluated once and again for intervals.

Source: EMVA Standard 1288, Release 4.0 Linear: Sec. 2 (the linear model), 6 (sensitivity and noise), 7
(linearity).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.emva_calibration.levels import FINEST_DN2, Array, Brights, Darks, Selection, at_exposure
from tacos_plugins.noise_calibration.photon_transfer import ROUNDING_DN2

FINEST_NOISE_DN = 0.40
"""Dark noise is below this over K where rounding hides it (Sec. 6.5) [DN]."""

_LEAST_EXPOSURES = 3


def figures(brights: Brights, darks: Darks, selected: Selection) -> dict[str, float]:
    """Every figure of a channel by its name in ``result.json``; NaN where the frames do not tell it."""
    known = bool(np.isfinite(brights.photons).all())
    at_zero = dark_line(darks)
    signal, light = signals(brights, darks, selected)
    gain = system_gain(brights, darks, selected)
    fitted = selected.fitted
    slope = line(brights.photons[fitted], signal[fitted], offset=False)[1] if known else np.nan
    efficiency = slope / gain
    variance = np.nan if selected.darks_censored else at_zero["variance_dn2"]
    noise = np.sqrt(max(variance - ROUNDING_DN2, 0.0)) / gain
    if variance < FINEST_DN2:
        variance, noise = FINEST_DN2, FINEST_NOISE_DN / gain
    if selected.darks_censored:
        noise = np.nan
    least_e = np.sqrt(variance / gain**2 + 0.25) + 0.5 if np.isfinite(variance) else np.nan
    full_e = np.nan
    if selected.saturation is not None:
        at = selected.saturation
        full_e = efficiency * brights.photons[at] if known else signal[at] / gain
    errors = linearity(light, signal, selected.linear)
    return {
        "system_gain_dn_per_e": gain,
        "quantum_efficiency": efficiency,
        "responsivity_dn_per_photon": slope,
        "dark_noise_e": noise,
        "black_level_dn": _black(brights, darks, selected),
        "saturation_capacity_e": full_e,
        "saturation_capacity_photons": full_e / efficiency,
        "snr_max": np.sqrt(full_e),
        "snr_max_db": 10 * np.log10(full_e),
        "absolute_sensitivity_threshold_e": least_e,
        "absolute_sensitivity_threshold_photons": least_e / efficiency,
        "dynamic_range": full_e / least_e,
        "dynamic_range_db": 20 * np.log10(full_e / least_e),
        "dark_current_e_s": at_zero["mean_dn_s"] / gain,
        "dark_current_from_variance_e_s": at_zero["variance_dn2_s"] / gain**2,
        "dark_signal_e": at_zero["mean_dn_s"] * float(darks.exposure_s.max()) / gain,
        "linearity_error_percent": float(np.mean(np.abs(errors))) if len(errors) else np.nan,
        "linearity_error_min_percent": float(errors.min()) if len(errors) else np.nan,
        "linearity_error_max_percent": float(errors.max()) if len(errors) else np.nan,
    }


def signals(brights: Brights, darks: Darks, selected: Selection) -> tuple[Array, Array]:
    """Mean above darkness [DN], and the light in photons, or in seconds of exposure; NaN for neither."""
    light = brights.photons if np.isfinite(brights.photons).all() else brights.exposure_s
    if np.ptp(light) == 0:
        light = np.full_like(light, np.nan)
    if not selected.darks_censored:
        return brights.mean_dn - at_exposure(darks, darks.mean_dn, brights.exposure_s), light
    return brights.mean_dn - _black(brights, darks, selected), light


def system_gain(brights: Brights, darks: Darks, selected: Selection) -> float:
    """K, the slope of variance over mean [DN/e-], darkness subtracted (Sec. 6.6).

    Darkness that rounding hides or that is cut off at 0 says nothing of its own variance: then the line has
    an offset instead, and dim levels, whose variance is known best, weigh most.
    """
    of_fit = selected.fitted
    if selected.free_offset:
        return free_transfer(brights, selected)[1]
    signal = brights.mean_dn - at_exposure(darks, darks.mean_dn, brights.exposure_s)
    variance = brights.variance_dn2 - at_exposure(darks, darks.variance_dn2, brights.exposure_s)
    return line(signal[of_fit], variance[of_fit], offset=False)[1]


def free_transfer(brights: Brights, selected: Selection) -> tuple[float, float]:
    """Offset [DN^2] and slope [DN] of variance over mean: a level counts once, however many its frames.

    Chance scatters each variance by one share of itself; errors would let a stack of frames rule the line.
    """
    used = selected.fitted
    mean, variance = brights.mean_dn[used], brights.variance_dn2[used]
    slope, offset = np.polyfit(mean, variance, 1, w=1 / variance)
    return float(offset), float(slope)


def linearity(light: Array, signal: Array, linear: NDArray[np.bool_]) -> Array:
    """Relative deviations from the line that makes them least, 5 to 95 % of saturation (Sec. 7.2) [%]."""
    x, y = light[linear], signal[linear]
    if len(x) < _LEAST_EXPOSURES or not np.isfinite(x).all():
        return np.empty(0)
    powers = np.stack([np.ones_like(x), x], axis=1) / y[:, None]
    fitted = np.linalg.lstsq(powers, np.ones_like(y), rcond=None)[0]
    expected = fitted[0] + fitted[1] * x
    return np.asarray(100 * (y - expected) / expected, dtype=np.float64)


def dark_line(darks: Darks) -> Mapping[str, float]:
    """Darkness at no exposure, and how it grows with it; without slopes where fewer than three differ."""
    total = darks.variance_dn2 + darks.bands_dn2
    if len(np.unique(darks.exposure_s)) < _LEAST_EXPOSURES:
        shortest = darks.exposure_s == darks.exposure_s.min()
        values = float(darks.mean_dn[shortest].mean()), float(total.mean())
        return {
            "mean_dn": values[0], "variance_dn2": values[1], "mean_dn_s": np.nan, "variance_dn2_s": np.nan,
        }  # fmt: skip
    mean, variance = (line(darks.exposure_s, y, offset=True) for y in (darks.mean_dn, total))
    return {
        "mean_dn": mean[0], "variance_dn2": variance[0],
        "mean_dn_s": mean[1], "variance_dn2_s": variance[1],
    }  # fmt: skip


def line(x: Array, y: Array, *, offset: bool) -> tuple[float, float]:
    """Offset and slope of a straight line by least squares; the offset is 0 where there is none."""
    if not offset:
        return 0.0, float(x @ y / (x @ x))
    centre = float(x.mean())
    slope = float((x - centre) @ y / ((x - centre) @ (x - centre)))
    return float(y.mean()) - slope * centre, slope


def _black(brights: Brights, darks: Darks, selected: Selection) -> float:
    """Mean without light and exposure; where darkness is cut off, what bright levels extrapolate to [DN]."""
    light = brights.photons if np.isfinite(brights.photons).all() else brights.exposure_s
    if selected.darks_censored and np.ptp(light[selected.fitted]) > 0:
        return line(light[selected.fitted], brights.mean_dn[selected.fitted], offset=True)[0]
    return dark_line(darks)["mean_dn"]
