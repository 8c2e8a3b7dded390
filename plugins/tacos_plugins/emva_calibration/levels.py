"""Levels of a channel as arrays, and which of them each figure rests on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Fault, UserError
from tacos_plugins.emva_calibration.measurement import LEAST_LEVELS, Channel
from tacos_plugins.noise_calibration.photon_transfer import ROUNDING_DN2

Array = NDArray[np.float64]

FIT_SHARE = 0.7
"""Of saturation, up to which responsivity and gain are fitted (EMVA 1288, Release 4.0 Linear, Sec. 6.6)."""

LINEAR_SHARES = (0.05, 0.95)
"""Of saturation, between which linearity is judged (Sec. 7.2)."""

FINEST_DN2 = 0.24
"""Variance below which rounding hides the noise (Sec. 6.5) [DN^2]."""

CENSORED_SHARE = 1e-3
"""Share of samples at either end from which a level counts as cut off [1]."""

_COLLAPSED = 0.8
_EARLY = 0.5


@dataclass(frozen=True)
class Darks:
    """Dark levels by exposure; (D,) each. Variance is that within rows; bands are shared by whole rows."""

    exposure_s: Array
    mean_dn: Array
    mean_error_dn: Array
    variance_dn2: Array
    variance_error_dn2: Array
    bands_dn2: Array
    bands_error_dn2: Array


@dataclass(frozen=True)
class Brights:
    """Bright levels from dim to bright; (L,) each. Photons are NaN where they are not known."""

    exposure_s: Array
    photons: Array
    mean_dn: Array
    variance_dn2: Array
    variance_error_dn2: Array
    censored: NDArray[np.bool_]


@dataclass(frozen=True)
class Selection:
    """The levels that each figure rests on, decided once from the measurements."""

    fitted: NDArray[np.bool_]
    linear: NDArray[np.bool_]
    """(L,) levels of the fits of responsivity and gain, and of linearity."""
    saturation: int | None
    """Index of the saturated level; None where no level saturates."""
    darks_censored: bool
    """True if darkness is cut off at 0."""
    darks_fine: bool
    """True if darkness varies by less than rounding shows."""

    @property
    def free_offset(self) -> bool:
        """True if darkness cannot be subtracted, and lines have an offset of their own."""
        return self.darks_censored or self.darks_fine


def arrays_of(channel: Channel) -> tuple[Brights, Darks]:
    """Levels of a channel, by exposure and by light."""
    darks = channel.of("dark")
    moments = [each for _, each in darks]
    errors = [
        max(np.sqrt(m.variance_dn2 / (m.pixels * m.frames)), m.drift_dn / np.sqrt(2 * m.frames))
        for m in moments
    ]
    of_darks = Darks(
        np.array([group.exposure_s for group, _ in darks]),
        np.array([m.mean_dn for m in moments]),
        np.array(errors),
        np.array([m.variance_dn2 for m in moments]),
        np.array([m.variance_error_dn2 for m in moments]),
        np.array([m.bands_dn2 for m in moments]),
        np.array([m.bands_error_dn2 for m in moments]),
    )
    white = 2**channel.bit_depth - 1
    key = {True: lambda each: (each[0].photons, each[1].mean_dn), False: lambda each: each[1].mean_dn}
    brights = channel.of("bright")
    known = all(group.photons is not None for group, _ in brights)
    brights = sorted(brights, key=key[known])
    lit = [each for _, each in brights]
    return Brights(
        np.array([group.exposure_s for group, _ in brights]),
        np.array([np.nan if group.photons is None else group.photons for group, _ in brights], float),
        np.array([m.mean_dn for m in lit]),
        np.array([m.variance_dn2 for m in lit]),
        np.array([m.variance_error_dn2 for m in lit]),
        np.array(
            [
                m.at_zero > CENSORED_SHARE or (m.highest_dn >= white and m.at_highest > CENSORED_SHARE)
                for m in lit
            ]
        ),
    ), of_darks


def at_exposure(darks: Darks, values: Array, exposure_s: Array) -> Array:
    """Values of darkness at other exposures: those of the same one, or on the line between two neighbours."""
    times, of_time = np.unique(darks.exposure_s, return_inverse=True)
    return np.interp(exposure_s, times, np.bincount(of_time, values) / np.bincount(of_time))


def select(channel: Channel, brights: Brights, darks: Darks, where: str) -> Selection:
    """Decide on what each figure rests.

    Raises `UserError` when fewer than three levels are left for the gain.
    """
    signal = brights.mean_dn - at_exposure(darks, darks.mean_dn, brights.exposure_s)
    saturation = _saturation(brights)
    top = float(signal[saturation] if saturation is not None else signal.max())
    upto = np.arange(len(signal)) <= (len(signal) - 1 if saturation is None else saturation)
    censored = any(m.at_zero > CENSORED_SHARE for _, m in channel.of("dark"))
    fine = float(np.mean(darks.variance_dn2 + darks.bands_dn2)) < FINEST_DN2
    usable = upto & ~brights.censored & (signal > 0)
    fitted = usable & (signal <= FIT_SHARE * top)
    if censored or fine:
        fitted &= brights.variance_dn2 >= FINEST_DN2 + ROUNDING_DN2
    if fitted.sum() < LEAST_LEVELS:
        what, expected, remedy = _too_few(brights, signal, saturation, int(fitted.sum()))
        raise UserError(Fault(f"{where}, channel {channel.name}", what, expected, remedy))
    low, high = LINEAR_SHARES
    linear = usable & (signal >= low * top) & (signal <= high * top)
    return Selection(fitted, linear, saturation, censored, fine)


def _too_few(brights: Brights, signal: Array, saturation: int | None, fitted: int) -> tuple[str, str, str]:
    """Why the levels do not give a gain, what would, and what to do."""
    levels, cut = len(signal), int(brights.censored.sum())
    if np.median(signal) <= 0:
        return (
            f"bright frames are no brighter than dark ones: half of {levels} levels lie "
            f"{-np.median(signal):.3g} DN below darkness, or deeper",
            "kind: bright for frames of light, and dark for those without",
            "Exchange the two words in frames.csv, where they stand for the other.",
        )
    if cut == levels:
        return (
            f"all of {levels} bright levels are cut off at 0 or at full scale",
            f"levels from darkness to {FIT_SHARE:.0%} of saturation",
            "Take shorter exposures, or less light.",
        )
    if saturation is not None and signal[saturation] < _EARLY * signal.max():
        return (
            f"the variance falls from {brights.mean_dn[saturation]:.4g} DN on, and the brightest level has "
            f"{brights.mean_dn.max():.4g} DN: a tone curve lies over the samples",
            "samples in proportion to the light",
            "Switch off gamma, tone curve and automatic gain, and save raw frames.",
        )
    return (
        f"{fitted} of {levels} bright levels serve for the gain; cut off at 0 or at full scale: {cut}; "
        f"the others lie above {FIT_SHARE:.0%} of saturation or below what rounding shows",
        f"{LEAST_LEVELS} levels or more from darkness to {FIT_SHARE:.0%} of saturation, better 50",
        "Take shorter exposures, or less light. Set bit_depth where files have fewer bits than it says.",
    )


def _saturation(brights: Brights) -> int | None:
    """The brightest level before variance falls: the maximum of the photon transfer (Sec. 6.6)."""
    variance, error = brights.variance_dn2, brights.variance_error_dn2
    top = int(np.argmax(variance))
    fallen = np.flatnonzero(variance[top:] < _COLLAPSED * variance[top])
    if not len(fallen):
        return None
    plateau = np.arange(top, top + int(fallen[0]))
    high = plateau[variance[plateau] >= variance[top] - 3 * error[top]]
    return int(high[-1])
