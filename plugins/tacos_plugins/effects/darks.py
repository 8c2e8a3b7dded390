"""Pixels and lines that stay bright in dark frames, with a pedestal or cut off at 0."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Captures, ObservedCapture, of_kind

ROUNDING_DN = 0.5
"""Least value seen in a file of whole numbers, without noise [DN]."""

_SPREADS = 6.0
_NORMAL_MAD = 1.4826
"""Standard deviation of normal values over their median absolute deviation."""

_NORMAL_QUANTILE = 0.8413
"""Share of normal values below one standard deviation."""


def middle_and_spread(values: NDArray[np.floating]) -> tuple[float, float]:
    """Median, and the standard deviation of normal noise of which anything below the median may be cut off.

    It is the larger of those by the median absolute deviation and by the quantile one deviation above the
    median; 0 where nearly all values are alike.
    """
    middle, upper = (float(level) for level in np.quantile(values, (0.5, _NORMAL_QUANTILE)))
    return middle, max(_NORMAL_MAD * float(np.median(np.abs(values - middle))), upper - middle)


def isolated(bright: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The bright pixels of an (H, W[, C]) image that are not within a bright piece of a row or column."""
    apart = bright.copy()
    apart[1:-1] &= ~(bright[:-2] & bright[2:])
    apart[:, 1:-1] &= ~(bright[:, :-2] & bright[:, 2:])
    return apart


_APART = 2.0
"""Longest over shortest exposure time from which on two darks show how the dark grows."""


def pedestal_dn(shortest: tuple[float, float], longest: tuple[float, float]) -> float:
    """Level of the dark at no exposure, by a line through two darks, (exposure time [s], level [DN]) each.

    That of the shorter one where the times are too near each other, or the dark does not grow.

    >>> round(pedestal_dn((0.02, 100.4), (0.2, 104.0)), 6)
    100.0
    """
    (first_s, first_dn), (last_s, last_dn) = shortest, longest
    if last_s < _APART * first_s or last_s == first_s or last_dn < first_dn:
        return first_dn
    return first_dn - (last_dn - first_dn) * first_s / (last_s - first_s)


@dataclass(frozen=True, eq=False)
class SteadyDark:
    """The part of a dark above its middle that all frames share."""

    capture: ObservedCapture
    above_dn: NDArray[np.float32]
    """(H, W, C) the least of the frames, less the median of all pixels [DN]."""
    lowest_dn: float
    """Level that noise and rounding seldom reach: pixels above it are bright [DN]."""

    @cached_property
    def bright(self) -> NDArray[np.bool_]:
        """(H, W, C) bright pixels, hot ones and those of lines."""
        return np.asarray(self.above_dn > self.lowest_dn)

    @cached_property
    def hot_dn(self) -> NDArray[np.float32]:
        """(P,) values of the bright pixels that stand alone [DN]."""
        return np.asarray(self.above_dn[isolated(self.bright)])

    @property
    def level_dn(self) -> float:
        """Mean of the frames without their bright pixels [DN]."""
        rest = ~self.bright
        return float(self.capture.real_dn.mean(axis=0)[rest].mean()) if rest.any() else 0.0

    @property
    def is_cut_off(self) -> bool:
        """True if most pixels stand at the lower end of the codes, noise and offsets below it unseen."""
        return bool(np.mean(self.capture.real_dn <= 0) > 0.5)


def steady_darks(captures: Captures) -> list[SteadyDark]:
    return sorted(map(_steady, of_kind(captures, "dark")), key=lambda d: d.capture.context.exposure_s)


def _steady(capture: ObservedCapture) -> SteadyDark:
    steady = capture.real_dn.min(axis=0)
    _, spread = middle_and_spread(capture.real_dn[0])
    return SteadyDark(capture, steady - np.median(steady), ROUNDING_DN + _SPREADS * spread)
