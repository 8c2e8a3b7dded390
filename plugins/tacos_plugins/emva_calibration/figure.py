"""Photon transfer, linearity and signal-to-noise ratio of a data sheet."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from tacos_plugins.emva_calibration.data_sheet import DataSheet
from tacos_plugins.emva_calibration.evaluation import line, linearity, signals
from tacos_plugins.emva_calibration.levels import at_exposure
from tacos_plugins.noise_calibration.photon_transfer import ROUNDING_DN2
from tacos_report.figures.canvas import NARROW_IN, draw, light_grid, logarithmic_height
from tacos_report.palette import MUTED, RULE, camera_colour

_COLOUR = camera_colour(1)


def transfer(sheet: DataSheet, *, narrow: bool = False) -> str:
    """SVG of variance over mean, darkness subtracted where it can be, with the line of the system gain."""
    signal, _ = signals(sheet.brights, sheet.darks, sheet.selected)
    dark = at_exposure(sheet.darks, sheet.darks.variance_dn2, sheet.brights.exposure_s)
    variance = sheet.brights.variance_dn2 - (0 if sheet.selected.free_offset else dark)
    used = sheet.selected.fitted
    offset, slope = line(signal[used], variance[used], offset=sheet.selected.free_offset)

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        axes.plot(signal[~used], variance[~used], "o", color=RULE, markersize=4)
        axes.plot(signal[used], variance[used], "o", color=_COLOUR, markersize=4, label="levels of the fit")
        x = np.array([0.0, signal.max()])
        axes.plot(x, offset + slope * x, "-", color=MUTED, linewidth=1.2, label=f"K = {slope:.4g} DN/e-")
        axes.set_xlabel("μ_y - μ_y.dark [DN]")
        axes.set_ylabel("σ²_y - σ²_y.dark [DN²]")
        axes.set_ylim(bottom=0)
        axes.legend(loc="upper left", labelcolor=MUTED)
        light_grid(axes, "y")

    return draw("transfer" + "-narrow" * narrow, _size(narrow), "Photon transfer: variance over mean.", paint)


def linearity_drawing(sheet: DataSheet, *, narrow: bool = False) -> str:
    """SVG of the mean over light, and of what it is off the straight line."""
    signal, light = signals(sheet.brights, sheet.darks, sheet.selected)
    used = sheet.selected.linear
    rest = linearity(light, signal, used)
    unit = "photons per pixel" if np.isfinite(sheet.brights.photons).all() else "exposure time [s]"

    def paint(figure: Figure) -> None:
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        above.plot(light[~used], signal[~used], "o", color=RULE, markersize=4)
        above.plot(light[used], signal[used], "o", color=_COLOUR, markersize=4)
        above.set_ylabel("μ_y - μ_y.dark [DN]")
        if len(rest):
            below.plot(light[used], rest, "o", color=_COLOUR, markersize=4)
        below.axhline(0, color=MUTED, linewidth=0.8)
        below.set_ylabel("off the line [%]")
        below.set_xlabel(unit)
        for axes in (above, below):
            light_grid(axes, "y")

    return draw("linearity" + "-narrow" * narrow, _size(narrow), "Linearity: mean over light.", paint)


def signal_to_noise(sheet: DataSheet, *, narrow: bool = False) -> str:
    """SVG of SNR over electrons, measured and by the linear model."""
    gain = sheet.value("system_gain_dn_per_e") or np.nan
    signal, _ = signals(sheet.brights, sheet.darks, sheet.selected)
    upto = len(signal) if sheet.selected.saturation is None else sheet.selected.saturation + 1
    bands = at_exposure(sheet.darks, sheet.darks.bands_dn2, sheet.brights.exposure_s)
    total = sheet.brights.variance_dn2 + bands
    kept = (np.arange(len(signal)) < upto) & (signal > 0) & (total > 0)
    electrons = signal[kept] / gain
    noise = sheet.value("dark_noise_e") or 0.0

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        axes.plot(
            electrons, signal[kept] / np.sqrt(total[kept]), "o", color=_COLOUR, markersize=4, label="measured"
        )
        x = np.geomspace(1, electrons.max(), 100)
        model = x / np.sqrt(noise**2 + ROUNDING_DN2 / gain**2 + x)
        axes.plot(x, model, "-", color=MUTED, linewidth=1.2, label="linear model")
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        logarithmic_height(axes)
        axes.set_xlabel("electrons")
        axes.set_ylabel("SNR")
        axes.legend(loc="upper left", labelcolor=MUTED)
        light_grid(axes, "y")

    return draw("snr" + "-narrow" * narrow, _size(narrow), "Signal-to-noise ratio over electrons.", paint)


def _size(narrow: bool) -> tuple[float, float]:
    return (NARROW_IN, 4.0) if narrow else (7.4, 4.4)
