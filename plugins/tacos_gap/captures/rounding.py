"""Noise after rounding to whole numbers, and before it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from tacos_plugins.noise_calibration.photon_transfer import ROUNDING_DN2

_AS_IF_UNIFORM_DN2 = 0.5
"""From this variance on that holds to a thousandth, wherever the level lies between two numbers."""

_VARIANCES_DN2 = np.geomspace(1e-4, 1.0, 200)
_HALVINGS = 24


class BeforeRounding(NamedTuple):
    """Normal noise before it was rounded.

    - `variance_dn2`: its variance, never below 0 [DN^2].
    - `steepness`: change of the rounded variance with it at one mean of the whole numbers, from 0 to 1: where
      all values are two numbers, their mean says it all, and their variance nothing.
    """

    variance_dn2: float
    steepness: float


def before_rounding(variance_dn2: float, mean_dn: float) -> BeforeRounding:
    """Normal noise of which rounding made whole numbers of such a variance and mean.

    Little noise about a whole number is mostly rounded away, midway between two it shows; and it draws the
    mean towards the nearest whole number.

    >>> before_rounding(4.0, 100.0).variance_dn2 == 4.0 - ROUNDING_DN2
    True
    >>> round(before_rounding(0.0498, 8.0).variance_dn2, 3)  # a pedestal of 8, and noise of .255 DN
    0.065
    """
    if variance_dn2 > _AS_IF_UNIFORM_DN2:  # Widrow 1956
        return BeforeRounding(variance_dn2 - ROUNDING_DN2, 1.0)
    _, rounded = after_rounding(_levels_of(mean_dn % 1.0), _VARIANCES_DN2)
    rounded = np.maximum.accumulate(rounded)
    steepness = np.gradient(rounded, _VARIANCES_DN2)
    if variance_dn2 <= rounded[0]:
        return BeforeRounding(0.0, float(np.clip(steepness[0], 0.0, 1.0)))
    found = float(np.interp(variance_dn2, rounded, _VARIANCES_DN2))
    return BeforeRounding(found, float(np.clip(np.interp(found, _VARIANCES_DN2, steepness), 0.0, 1.0)))


def after_rounding(
    levels_dn: NDArray[np.float64], variances_dn2: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(V,) means and (V,) variances of whole numbers, of (V,) levels and variances of normal noise."""
    codes = np.arange(-8.0, 10.0)
    spread, level = np.sqrt(variances_dn2)[:, None], levels_dn[:, None]
    shares = ndtr((codes + 0.5 - level) / spread) - ndtr((codes - 0.5 - level) / spread)
    mean = shares @ codes
    return np.asarray(mean, np.float64), np.asarray(shares @ codes**2 - mean**2, np.float64)


def _levels_of(mean_dn: float) -> NDArray[np.float64]:
    """(V,) levels at which rounded noise of `_VARIANCES_DN2` has a mean from 0 to 1 [DN]."""
    low, high = np.full(_VARIANCES_DN2.shape, -1.0), np.full(_VARIANCES_DN2.shape, 2.0)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        is_below = after_rounding(middle, _VARIANCES_DN2)[0] < mean_dn
        low, high = np.where(is_below, middle, low), np.where(is_below, high, middle)
    return (low + high) / 2


def are_whole(values_dn: NDArray[np.floating]) -> bool:
    some = values_dn.reshape(-1)[::101]
    return bool(np.all(some == np.rint(some)))
