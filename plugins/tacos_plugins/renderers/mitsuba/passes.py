"""Number of paths of a pixel, and of passes."""

from __future__ import annotations


def samples_per_pose(samples: int, poses: int) -> int:
    """Paths per pixel for each of the poses of an exposure, rounded up."""
    return -(-samples // poses)


def in_passes(samples: int, most: int, *, even: bool) -> list[int]:
    """Paths per pixel of each pass, at most `most`; `even` ones come in powers of four.

    >>> in_passes(64, 30, even=False), in_passes(64, 30, even=True)
    ([30, 30, 4], [16, 16, 16, 16])
    """
    size = most
    if even:
        size = samples
        while size > most:
            size //= 4
    return [size] * (samples // size) + [samples % size] * (samples % size > 0)


def is_power_of_four(number: int) -> bool:
    """True if it is 1, 4, 16, 64, ...

    >>> [number for number in range(1, 70) if is_power_of_four(number)]
    [1, 4, 16, 64]
    """
    return number.bit_count() == 1 and number.bit_length() % 2 == 1
