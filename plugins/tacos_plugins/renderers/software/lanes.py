"""Room for loops that take several numbers at once, also of what is shorter."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

LANES = 16
"""Numbers that are taken at once."""


def with_lanes(shape: tuple[int, ...], dtype: type[np.generic]) -> NDArray[Any]:
    """An array, not filled, with `LANES` more numbers behind it in memory that may be read and written.

    >>> band = with_lanes((4, 5), np.float32)
    >>> band.shape, band.base.size - band.size
    ((4, 5), 16)
    """
    count = math.prod(shape)
    return np.empty(count + LANES, dtype)[:count].reshape(shape)
