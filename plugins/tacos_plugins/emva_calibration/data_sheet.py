"""The data sheet of a channel: every figure with its interval, or the reason why there is none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tacos_framework import Fault, UserError
from tacos_plugins.emva_calibration.evaluation import figures
from tacos_plugins.emva_calibration.intervals import intervals
from tacos_plugins.emva_calibration.levels import Array, Brights, Darks, Selection, arrays_of, select
from tacos_plugins.emva_calibration.measurement import STACK_FRAMES, Channel
from tacos_plugins.emva_calibration.nonuniformity import SpatialVariance

_NO_PHOTONS = "photons_per_pixel is not given: measure the light with a calibrated photodiode."
_NO_SATURATION = "no level saturates: the variance never falls. Take brighter levels, up to full scale."
_CENSORED = "darkness is cut off at 0 DN. Raise the black level of the camera until no dark sample is 0."
_NO_EXPOSURES = "needs dark frames of three or more exposure times."
_NO_STACK = (
    f"needs a stack of {STACK_FRAMES} or more frames, better 50, at half saturation and one in darkness."
)
_NO_LINEARITY = (
    "needs three or more levels of different photons or exposures, between 5 and 95 % of saturation."
)
_ROUNDED = "an upper limit: the variance of darkness is below 0.24 DN², where rounding hides the noise."

NAMES: Mapping[str, tuple[str, str]] = {
    "quantum_efficiency": ("Quantum efficiency η", "1"),
    "system_gain_dn_per_e": ("Overall system gain K", "DN/e-"),
    "dark_noise_e": ("Temporal dark noise σ_d", "e-"),
    "snr_max": ("Maximum signal-to-noise ratio SNR_max", "1"),
    "snr_max_db": ("Maximum signal-to-noise ratio SNR_max", "dB"),
    "absolute_sensitivity_threshold_photons": ("Absolute sensitivity threshold μ_p.min", "photons"),
    "absolute_sensitivity_threshold_e": ("Absolute sensitivity threshold μ_e.min", "e-"),
    "saturation_capacity_photons": ("Saturation capacity μ_p.sat", "photons"),
    "saturation_capacity_e": ("Saturation capacity μ_e.sat", "e-"),
    "dynamic_range": ("Dynamic range DR", "1"),
    "dynamic_range_db": ("Dynamic range DR", "dB"),
    "dsnu_e": ("Dark signal nonuniformity DSNU_1288", "e-"),
    "prnu_percent": ("Photo response nonuniformity PRNU_1288", "%"),
    "linearity_error_percent": ("Linearity error LE", "%"),
    "dark_current_e_s": ("Dark current from the mean μ_I.mean", "e-/s"),
    "dark_current_from_variance_e_s": ("Dark current from the variance μ_I.var", "e-/s"),
    "dark_signal_e": ("Dark signal at the longest exposure", "e-"),
    "responsivity_dn_per_photon": ("Responsivity R", "DN/photon"),
    "black_level_dn": ("Black level", "DN"),
}
"""Figures of ``result.json`` in the words of the standard, with units; in the order of the sheet."""

_OF_DARKNESS = ("dsnu_e", "dark_current_e_s", "dark_current_from_variance_e_s", "dark_signal_e")
"""Figures that darkness gives by itself."""


@dataclass(frozen=True)
class Figure:
    """A figure with its 95 % interval; or, without a value, the reason."""

    value: float | None
    ci: tuple[float, float] | None
    unit: str
    reason: str = ""

    def as_data(self) -> dict[str, Any]:
        told = {"reason": self.reason} if self.reason else {}
        return {"value": self.value, "ci": self.ci and list(self.ci), "unit": self.unit, **told}


@dataclass(frozen=True)
class DataSheet:
    """All that was found of one channel."""

    channel: Channel
    brights: Brights
    darks: Darks
    selected: Selection
    figures: Mapping[str, Figure]
    bright_stack: SpatialVariance | None
    dark_stack: SpatialVariance | None

    def value(self, name: str) -> float | None:
        return self.figures[name].value


def data_sheet(channel: Channel, where: str, rng: np.random.Generator) -> DataSheet:
    """Evaluate a channel.

    Raises `UserError` when its levels do not give a system gain.
    """
    brights, darks = arrays_of(channel)
    selected = select(channel, brights, darks, where)
    with np.errstate(invalid="ignore", divide="ignore"):
        values = figures(brights, darks, selected)
    if not values["system_gain_dn_per_e"] > 0:
        raise UserError(
            Fault(
                f"{where}, channel {channel.name}",
                "the variance does not grow with brightness",
                "frames as the sensor gave them, whose noise grows with the light",
                "Switch off noise reduction, gamma and automatic gain, and save raw frames.",
            )
        )
    within, draws = intervals(brights, darks, selected, rng)
    bright, dark = _stacks(channel, brights, selected)
    of_space = _nonuniformity(bright, dark, draws["system_gain_dn_per_e"], rng)
    values |= {name: value for name, (value, _) in of_space.items()}
    within |= {name: ci for name, (_, ci) in of_space.items()}
    if selected.darks_censored:
        values |= dict.fromkeys(_OF_DARKNESS, np.nan)
    found = {
        name: _figure(name, unit, values.get(name, np.nan), within, selected)
        for name, (_, unit) in NAMES.items()
    }
    for name in ("linearity_error_min_percent", "linearity_error_max_percent"):
        found[name] = _figure(name, "%", values[name], {}, selected)
    return DataSheet(channel, brights, darks, selected, found, bright, dark)


def _figure(
    name: str, unit: str, value: float, within: Mapping[str, tuple[float, float]], selected: Selection
) -> Figure:
    if not np.isfinite(value):
        return Figure(None, None, unit, _reason(name, selected))
    ci = within.get(name)
    if name == "dark_noise_e" and selected.darks_fine:
        return Figure(float(value), (0.0, ci[1] if ci else float(value)), unit, _ROUNDED)
    if name.startswith("linearity"):  # scatter adds to deviations: draws lie above
        ci = None
    return Figure(float(value), ci, unit)


def _reason(name: str, selected: Selection) -> str:
    if selected.darks_censored and name.startswith((*_OF_DARKNESS, "dark_noise", "absolute", "dynamic")):
        return _CENSORED
    if name in ("prnu_percent", "dsnu_e"):
        return _NO_STACK
    if name.startswith("dark_current") or name == "dark_signal_e":
        return _NO_EXPOSURES
    if name.startswith("linearity"):
        return _NO_LINEARITY
    if selected.saturation is None and name.startswith(("saturation", "snr", "dynamic")):
        return _NO_SATURATION
    return _NO_PHOTONS


def _stacks(
    channel: Channel, brights: Brights, selected: Selection
) -> tuple[SpatialVariance | None, SpatialVariance | None]:
    """The bright stack nearest to half saturation, and the dark one nearest to its exposure."""
    top = float(brights.mean_dn[-1 if selected.saturation is None else selected.saturation])
    lit = [each for each in channel.stacks if each[0].kind == "bright" and each[1].mean_dn < 0.95 * top]
    dark = [each for each in channel.stacks if each[0].kind == "dark"]
    chosen = min(lit, key=lambda each: abs(each[1].mean_dn - top / 2), default=None)
    if chosen is None:
        return None, max(dark, key=lambda each: each[1].frames)[1] if dark else None
    nearest = min(dark, key=lambda each: abs(each[0].exposure_s - chosen[0].exposure_s), default=None)
    return chosen[1], nearest and nearest[1]


def _nonuniformity(
    bright: SpatialVariance | None, dark: SpatialVariance | None, gains: Array, rng: np.random.Generator
) -> dict[str, tuple[float, tuple[float, float]]]:
    """DSNU [e-] and PRNU [%] with intervals (Sec. 8.3); variances below 0, made by chance, count as 0."""
    if dark is None:
        return {}
    of_dark = dark.total_dn2 + dark.error_dn2 * rng.standard_normal(len(gains))
    gain = float(np.median(gains))
    found = {"dsnu_e": (_root(dark.total_dn2) / gain, _interval(_root(of_dark) / gains))}
    if bright is not None:
        signal = bright.mean_dn - dark.mean_dn
        of_light = bright.total_dn2 + bright.error_dn2 * rng.standard_normal(len(gains))
        value = 100 * _root(bright.total_dn2 - dark.total_dn2) / signal
        found["prnu_percent"] = (value, _interval(100 * _root(of_light - of_dark) / signal))
    return found


def _root(variance: Any) -> Any:
    return np.sqrt(np.maximum(variance, 0.0))


def _interval(draws: Array) -> tuple[float, float]:
    low, high = np.percentile(draws, (2.5, 97.5))
    return float(low), float(high)
