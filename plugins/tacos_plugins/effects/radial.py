"""Even polynomials of the radius: what grows or falls towards the corners."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FIELD_RADIUS = np.linspace(0, 1, 21)
"""Radii from the centre to a corner at which a polynomial is looked at, over half the diagonal [1]."""

AS_GOOD_AS_LEVEL = 0.01
"""Tolerated dip below 1 of a polynomial that should only rise, or rise that should only fall [1]."""


def even_polynomial(radius: NDArray[np.float64], *coefficients: float) -> NDArray[np.float64]:
    """``1 + k1 r^2 + k2 r^4 + ...``, never below 0.

    `radius`: over half the sensor's diagonal, any shape [1]. `coefficients`: k1, k2, ... [1].

    >>> even_polynomial(np.array([0.0, 0.5, 1.0]), -0.4).tolist()
    [1.0, 0.9, 0.6]
    """
    r2 = radius**2
    rest = np.zeros_like(r2)
    for k in reversed(coefficients):
        rest = r2 * (k + rest)
    return np.maximum(1 + rest, 0.0)


def brightens(*coefficients: float) -> bool:
    """True if the polynomial rises above its value at the centre anywhere, as far as that matters."""
    return bool(np.max(even_polynomial(FIELD_RADIUS, *coefficients)) > 1 + AS_GOOD_AS_LEVEL)


def darkens(*coefficients: float) -> bool:
    """True if the polynomial falls below its value at the centre anywhere, as far as that matters."""
    return bool(np.min(even_polynomial(FIELD_RADIUS, *coefficients)) < 1 - AS_GOOD_AS_LEVEL)
