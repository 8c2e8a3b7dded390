"""Mean and variance of noise behind a curve."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.effects.samples import Moments

_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(15)
_WEIGHTS = _WEIGHTS / _WEIGHTS.sum()


def moments_behind(
    curve: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    mean_dn: NDArray[np.floating],
    variance_dn2: NDArray[np.floating],
) -> Moments:
    """Mean and variance of ``curve(x)`` for Gaussian x.

    To first order these are f(m) and f'(m)^2 v; Gauss-Hermite quadrature with 15 nodes also holds where the
    curve bends within the noise, as near black.

    `curve`: maps an array of samples to one of the same shape [DN]. `mean_dn`, `variance_dn2`: moments of x;
    they broadcast [DN, DN^2].

    >>> mean, variance = moments_behind(lambda x: 2 * x + 1, np.array([10.0]), np.array([4.0]))
    >>> mean.round(9).tolist(), variance.round(9).tolist()
    ([21.0], [16.0])
    """
    mean, variance = np.broadcast_arrays(
        np.asarray(mean_dn, np.float64), np.asarray(variance_dn2, np.float64)
    )
    deviation = np.sqrt(variance)
    first, second = np.zeros(mean.shape), np.zeros(mean.shape)
    centre = curve(mean)  # taken out of the squares, which else lose the variance to rounding
    for node, weight in zip(_NODES, _WEIGHTS, strict=True):
        value = curve(mean + node * deviation) - centre
        first += weight * value
        second += weight * value**2
    return centre + first, np.maximum(second - first**2, 0.0)
