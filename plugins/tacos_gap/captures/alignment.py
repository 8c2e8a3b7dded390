"""Files whose values are not the camera's own numbers: shifted up, or divided by full scale."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

FEWEST_UNUSED = 2
"""Low bits that no value uses from which on values are doubted: one is unused in many a converter."""

REMEDY = "Multiply by full scale, 255 for 8 bits or 4095 for 12, and save whole numbers."
"""What to do about values from 0 to 1."""


def used_bits(image: NDArray[Any]) -> int:
    """The bits that any value of an image uses; all of them where it holds no whole numbers.

    >>> used_bits(np.array([16, 32]))
    48
    """
    if image.dtype.kind == "f":
        if not np.array_equal(image, np.rint(image)):
            return -1
        image = image.astype(np.int64)
    return int(np.bitwise_or.reduce(image, axis=None))


def low_bits_unused(used: int) -> int:
    """Lowest bits that no value uses; 0 where all values are 0.

    >>> low_bits_unused(48)
    4
    """
    return (used & -used).bit_length() - 1 if used else 0


def shifted_left(bits: int, unused: int) -> str:
    """Sentence on values of so many bits that stand in the upper ones of their files."""
    return (
        f"Every value is a multiple of {2**unused}, as where {bits} bits are stored in the upper bits of a "
        f"file: divide by {2**unused}, else these steps are taken for the camera's own quantisation."
    )


def is_share_of_full_scale(image: NDArray[Any]) -> bool:
    """True if values are fractions up to 1, with noise about 0, and no digital numbers."""
    return (
        image.dtype.kind == "f"
        and image.size > 0
        and bool(0 < image.max() <= 1 and image.min() > -1)
        and not np.array_equal(image, np.rint(image))
    )
