"""Noise after rounding to whole numbers, and before it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from tacos_plugins.noise_calibration.photon_transfer import ROUNDING_DN2

_AS_IF_UNIFORM_DN2 = 0.5
"""From this variance on that holds to a thousandth, wherever the level lies between two numbers."""

_VARIANCES_DN2 = np.geomspace(1e-4, 1.0, 200)


def before_rounding(variance_dn2: float, level_dn: float) -> float:
    """Variance of normal noise before it was rounded, never below 0 [DN^2].

    - `variance_dn2`: of the whole numbers.
    - `level_dn`: their mean: little noise about a whole number is mostly rounded away, midway between two it
      shows.

    >>> before_rounding(4.0, 100.0) == 4.0 - ROUNDING_DN2
    True
    >>> round(before_rounding(0.0498, 8.0), 3)  # a pedestal of 8, and noise of .255 DN
    0.065
    """
    if variance_dn2 > _AS_IF_UNIFORM_DN2:  # Widrow 1956
        return variance_dn2 - ROUNDING_DN2
    rounded = variance_after_rounding(_VARIANCES_DN2, level_dn % 1.0)
    if variance_dn2 <= rounded[0]:
        return 0.0
    return float(np.interp(variance_dn2, np.maximum.accumulate(rounded), _VARIANCES_DN2))


def variance_after_rounding(variance_dn2: NDArray[np.float64], level_dn: float) -> NDArray[np.float64]:
    """(V,) variance of normal noise about a level, of (V,) variances, once it is rounded [DN^2]."""
    codes = np.arange(-8.0, 10.0)
    spread = np.sqrt(variance_dn2)[:, None]
    shares = ndtr((codes + 0.5 - level_dn) / spread) - ndtr((codes - 0.5 - level_dn) / spread)
    mean = shares @ codes
    return np.asarray(shares @ codes**2 - mean**2, np.float64)


def are_whole(values_dn: NDArray[np.floating]) -> bool:
    some = values_dn.reshape(-1)[::101]
    return bool(np.all(some == np.rint(some)))
