"""95 % intervals: what was measured is drawn anew within its errors, and evaluated each time.

Source: JCGM 101:2008, "Propagation of distributions using a Monte Carlo method".
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.emva_calibration.evaluation import figures, free_transfer, line, signals, system_gain
from tacos_plugins.emva_calibration.levels import Array, Brights, Darks, Selection, at_exposure

DRAWS = 1000
_QUANTILES = (2.5, 97.5)


def intervals(
    brights: Brights, darks: Darks, selected: Selection, rng: np.random.Generator
) -> tuple[dict[str, tuple[float, float]], dict[str, Array]]:
    """Intervals of all figures that are finite, and the (DRAWS,) draws behind them.

    Errors of variances follow from the fourth moments of the differences; where levels scatter about their
    line more than that, errors are widened accordingly. Light is as uncertain as signals scatter about the
    line of responsivity: this holds the lamp's wavering, and not the error of whoever measured the photons.
    """
    wide = _excess(brights, darks, selected)
    lamp = _lamp_scatter(brights, darks, selected)
    of_dark_mean = _dark_mean_error(darks)

    def around(values: Array, errors: Array) -> Array:
        return values + errors * rng.standard_normal(len(values))

    drawn: list[dict[str, float]] = []
    with np.errstate(invalid="ignore", divide="ignore"):
        for _ in range(DRAWS):
            of_light = replace(
                brights,
                photons=brights.photons * (1 + lamp * rng.standard_normal(len(brights.photons))),
                variance_dn2=around(brights.variance_dn2, wide * brights.variance_error_dn2),
            )
            of_dark = replace(
                darks,
                mean_dn=around(darks.mean_dn, of_dark_mean),
                variance_dn2=around(darks.variance_dn2, wide * darks.variance_error_dn2),
                bands_dn2=around(darks.bands_dn2, _bands_error(darks)),
            )
            drawn.append(figures(of_light, of_dark, selected))
    draws = {name: np.array([each[name] for each in drawn]) for name in drawn[0]}
    found: dict[str, tuple[float, float]] = {}
    for name, values in draws.items():
        finite = values[np.isfinite(values)]
        if len(finite):
            low, high = np.percentile(finite, _QUANTILES)
            found[name] = (float(low), float(high))
    return found, draws


def _excess(brights: Brights, darks: Darks, selected: Selection) -> float:
    """By how much levels scatter about the photon transfer beyond chance, 1 at least."""
    gain, used = system_gain(brights, darks, selected), selected.fitted
    if selected.free_offset:
        offset, _ = free_transfer(brights, selected)
        rest = brights.variance_dn2[used] - offset - gain * brights.mean_dn[used]
        error = brights.variance_error_dn2[used]
    else:
        dark = at_exposure(darks, darks.variance_dn2, brights.exposure_s)
        signal = brights.mean_dn - at_exposure(darks, darks.mean_dn, brights.exposure_s)
        rest = (brights.variance_dn2 - dark - gain * signal)[used]
        of_dark = at_exposure(darks, darks.variance_error_dn2, brights.exposure_s)
        error = np.hypot(brights.variance_error_dn2, of_dark)[used]
    freedom = max(int(used.sum()) - 1 - selected.free_offset, 1)
    return max(1.0, float(np.sqrt(np.sum((rest / error) ** 2) / freedom)))


def _lamp_scatter(brights: Brights, darks: Darks, selected: Selection) -> float:
    """Relative standard deviation of the light about the line of responsivity; 0 where it is not known."""
    if not np.isfinite(brights.photons).all():
        return 0.0
    signal, _ = signals(brights, darks, selected)
    x, y = brights.photons[selected.fitted], signal[selected.fitted]
    _, slope = line(x, y, offset=False)
    rest = (y - slope * x) / (slope * x)
    # The brighter half: there an offset of black weighs least.
    bright: NDArray[np.bool_] = x >= np.median(x)
    return float(np.sqrt(np.sum(rest[bright] ** 2) / max(int(bright.sum()) - 1, 1)))


def _dark_mean_error(darks: Darks) -> Array:
    """Standard errors of dark means [DN]: their scatter about the line over exposure where there is one."""
    if len(np.unique(darks.exposure_s)) < 4:
        return darks.mean_error_dn
    offset, slope = line(darks.exposure_s, darks.mean_dn, offset=True)
    rest = darks.mean_dn - offset - slope * darks.exposure_s
    scatter = np.sqrt(np.sum(rest**2) / (len(rest) - 2))
    return np.maximum(darks.mean_error_dn, scatter)


def _bands_error(darks: Darks) -> Array:
    """Standard errors of the bands of darkness: by chance, or by the scatter from exposure to exposure."""
    if len(darks.bands_dn2) < 4:
        return np.maximum(darks.bands_error_dn2, 0.1 * np.abs(darks.bands_dn2))
    return np.maximum(darks.bands_error_dn2, darks.bands_dn2.std(ddof=1))
