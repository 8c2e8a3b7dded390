"""Doubts about a data sheet, in sentences."""

from __future__ import annotations

import numpy as np

from tacos_plugins.emva_calibration.data_sheet import DataSheet
from tacos_plugins.emva_calibration.evaluation import linearity, signals
from tacos_plugins.emva_calibration.levels import Array, at_exposure

_CLEAR_Z = 5.0
_LEAST_BANDS, _LEAST_DRIFT = 5e-4, 3e-3
_CORRELATED = 0.1
_SCATTER_RATIO, _LEAST_SCATTERED = 1.0, 8
_STEADY_SHARE = 0.5
_NONLINEAR_PERCENT = 1.0
_LEAST_BEND, _BEND_Z = 0.10, 4.0
_GRADUAL_SHARE = 0.5
_MOSAIC_SHARE = 0.02


def doubts(sheet: DataSheet) -> list[str]:
    """Sentences about one channel, what matters most first."""
    found = [*_filtered(sheet), *_darkness(sheet), *_light(sheet), *_line(sheet), *_pattern(sheet)]
    if sheet.channel.step_dn > 1:
        found.append(
            f"samples are multiples of {sheet.channel.step_dn}: digital numbers are counted in these "
            "steps, as the "
            f"{sheet.channel.bit_depth} bits of the camera."
        )
    return found


def _filtered(sheet: DataSheet) -> list[str]:
    """Signs that frames are not as the sensor gave them."""
    found: list[str] = []
    fitted = np.flatnonzero(sheet.selected.fitted)
    levels = sorted(sheet.channel.of("bright"), key=lambda each: each[1].mean_dn)
    beside = float(np.median([levels[i][1].neighbours for i in fitted]))
    if abs(beside) > _CORRELATED:
        found.append(
            f"the noise of neighbouring pixels correlates ({beside:+.2f}): frames were smoothed, sharpened, "
            "demosaiced or scaled. Variance, and with it gain, quantum efficiency and dark noise, are wrong. "
            "Save raw frames."
        )
    efficiency = sheet.value("quantum_efficiency")
    if efficiency is not None and efficiency > 1:
        found.append(
            f"the quantum efficiency is {efficiency:.3g}, and no camera gives more than one electron for a "
            "photon: frames were smoothed or averaged, or photons_per_pixel is too small."
        )
    return found


def _darkness(sheet: DataSheet) -> list[str]:
    found, darks = [], sheet.darks
    if sheet.selected.darks_censored:
        share = max(m.at_zero for _, m in sheet.channel.of("dark"))
        found.append(
            f"darkness is cut off at 0 DN ({share:.1%} of dark samples are 0): its mean is too high "
            "and its variance "
            "too small. The gain rests on bright levels alone, and dark noise is not given. Raise "
            "the black level."
        )
    elif sheet.selected.darks_fine:
        found.append(
            "the variance of darkness is below 0.24 DN²: rounding hides the dark noise, which is "
            "given as an upper "
            "limit (0.40 DN over K). The gain is the slope of a line with an offset. Raise the gain, "
            "or save more bits."
        )
    z = float(darks.bands_dn2.sum() / np.sqrt(np.sum(darks.bands_error_dn2**2)))
    if z > _CLEAR_Z and darks.bands_dn2.mean() > 0.01 * darks.variance_dn2.mean():
        found.append(
            f"whole rows or columns vary together in darkness ({np.sqrt(darks.bands_dn2.mean()):.2g} "
            "DN): noise of "
            "rows of the camera itself, which counts as dark noise."
        )
    lit, times = sheet.brights.exposure_s, darks.exposure_s
    outside = (lit > times.max() * 1.001) | (lit < times.min() * 0.999)
    if outside.any():
        found.append(
            f"{outside.sum()} bright levels have exposures beyond those of the dark frames "
            f"({times.min() * 1e3:g} to {times.max() * 1e3:g} ms): the nearest darkness is "
            "subtracted from them."
        )
    return found


def _light(sheet: DataSheet) -> list[str]:
    """Bands and drift of the lamp: found beyond chance, and beyond what darkness has of them."""
    found: list[str] = []
    upto = len(sheet.brights.mean_dn) if sheet.selected.saturation is None else sheet.selected.saturation
    levels = sorted(sheet.channel.of("bright"), key=lambda each: each[1].mean_dn)[:upto]
    dark = at_exposure(sheet.darks, sheet.darks.mean_dn, np.array([g.exposure_s for g, _ in levels]))
    signal = np.array([m.mean_dn for _, m in levels]) - dark
    own = at_exposure(sheet.darks, sheet.darks.bands_dn2, np.array([g.exposure_s for g, _ in levels]))
    bands = np.array([m.bands_dn2 for _, m in levels]) - own
    error = np.array([m.bands_error_dn2 for _, m in levels])
    # A lamp's bands grow with its light: their share of the signal, each level weighed by how well it tells.
    weights = signal**2 / error**2
    share2 = float(np.sum(weights * bands) / np.sum(weights * signal**2))
    z = share2 * float(np.sqrt(np.sum(signal**4 / error**2)))
    single = float(np.max(bands / error)) if len(bands) else 0.0
    if share2 > _LEAST_BANDS**2 and z > _CLEAR_Z and single > _CLEAR_Z:
        found.append(
            f"bands run over the rows or columns of bright frames and differ from frame to frame "
            f"({np.sqrt(share2):.2%} of the signal): the lamp flickers, as on mains. They are taken "
            "off before the "
            "variance, and are no part of the noise. Use a lamp on direct current."
        )
    drift = np.array([m.drift_dn / np.sqrt(2) for _, m in levels])
    chance = np.array([np.sqrt(m.variance_dn2 / m.pixels) for _, m in levels])
    bright = signal > 0.1 * signal.max()
    rms = float(np.sqrt(np.mean((drift[bright] / signal[bright]) ** 2)))
    if rms > _LEAST_DRIFT and float(np.median(drift[bright] / chance[bright])) > 3:
        found.append(
            f"the light drifts or flickers by {rms:.1%} from one frame of a level to the next. It is "
            "taken off before "
            "the variance; photons and linearity suffer from it. Let the lamp warm up, and regulate it."
        )
    return found


def _line(sheet: DataSheet) -> list[str]:
    found: list[str] = []
    error = sheet.value("linearity_error_percent")
    signal, light = signals(sheet.brights, sheet.darks, sheet.selected)
    if error is not None and error > _NONLINEAR_PERCENT and _scattered(sheet, light, signal):
        found.append(
            f"levels scatter about a straight line by {error:.2g} % without order: the light, or what "
            "photons_per_pixel says of it, changes from level to level. Linearity is not known better."
        )
    elif error is not None and error > _NONLINEAR_PERCENT:
        found.append(
            f"the camera is not linear: LE {error:.2g} % (from "
            f"{sheet.value('linearity_error_min_percent'):+.2g} to "
            f"{sheet.value('linearity_error_max_percent'):+.2g} %). Switch off gamma, tone curve and "
            "automatic gain; "
            "gain, quantum efficiency and dark noise hold for a linear camera only."
        )
    used = sheet.selected.fitted
    x, y, e = signal[used], sheet.brights.variance_dn2[used], sheet.brights.variance_error_dn2[used]
    if len(x) > 5:
        powers = np.vander(x / x.max(), 3) / e[:, None]
        fitted, rest, *_ = np.linalg.lstsq(powers, y / e, rcond=None)
        wide = max(1.0, float(rest[0]) / (len(x) - 3)) if len(rest) else 1.0
        z = fitted[0] / np.sqrt(np.linalg.inv(powers.T @ powers)[0, 0] * wide)
        bend = fitted[0] / max(float(fitted.sum()), 1e-12)
        if abs(bend) > _LEAST_BEND and abs(z) > _BEND_Z:
            found.append(
                f"the photon transfer bends ({bend:+.0%} of the variance at the top of the fit): the "
                "camera is not "
                "linear, or filters its noise. The system gain is that of a straight line all the same."
            )
    if sheet.selected.saturation is None:
        found.append("no level saturates; the fit takes levels up to 70 % of the brightest one.")
    if used.sum() < 9:
        found.append(f"{used.sum()} levels carry the gain; the standard takes 9 or more, better 50.")
    return found


def _scattered(sheet: DataSheet, light: Array, signal: Array) -> bool:
    """True if deviations from linearity change from level to level at random, as no curve does.

    Source: von Neumann, "Distribution of the ratio of the mean square successive difference to the
    variance", Annals of Mathematical Statistics 12 (1941): 2 by chance, near 0 for a curve.
    """
    errors = linearity(light, signal, sheet.selected.linear)
    if len(errors) < _LEAST_SCATTERED:
        return False
    return float(np.mean(np.diff(errors) ** 2)) > _SCATTER_RATIO * float(errors.var())


def _pattern(sheet: DataSheet) -> list[str]:
    found: list[str] = []
    bright, dark = sheet.bright_stack, sheet.dark_stack
    if bright is not None and dark is not None:
        lit = bright.total_dn2 - dark.total_dn2
        for name, part in (
            ("rows", bright.row_dn2 - dark.row_dn2),
            ("columns", bright.column_dn2 - dark.column_dn2),
        ):
            if part > max(_STEADY_SHARE * lit, _CLEAR_Z * bright.error_dn2):
                share = np.sqrt(part) / (bright.mean_dn - dark.mean_dn)
                found.append(
                    f"whole {name} of bright frames differ by {share:.2%} of the signal, the same in each "
                    "frame: bands of a lamp in step with the exposures, or of the sensor itself. They count "
                    "in PRNU, and not in the noise. Use a lamp on direct current."
                )
    if bright is None or bright.gradual_dn2 < _CLEAR_Z * bright.error_dn2:
        return found
    if bright.gradual_dn2 > _GRADUAL_SHARE * bright.total_dn2 > 0:
        found.append(
            f"{bright.gradual_dn2 / bright.total_dn2:.0%} of the variance that PRNU stands for "
            "changes gradually over "
            "the image: uneven light or a lens that shades count in it. Light the bare sensor evenly."
        )
    return found


def of_mosaic(means_dn: np.ndarray, black_dn: float) -> list[str]:
    """Doubt an unnamed mosaic by the (2, 2) means of a bright frame [DN]."""
    signal = means_dn - black_dn
    spread = float(np.ptp(signal) / max(signal.mean(), 1e-9))
    if spread < _MOSAIC_SHARE:
        return []
    return [
        f"the four photosites of 2 x 2 differ by {spread:.0%}: where frames are a Bayer mosaic, name it "
        "(--set cfa=RGGB), so that colours are measured apart."
    ]
