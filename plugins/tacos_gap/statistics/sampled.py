"""Sampling of pixels: what is the same everywhere need not be measured everywhere.

Noise, codes and codecs are looked at in so many samples that chance is well below the equivalence margin of
their statistics; levels, patterns and detail, which differ from place to place, are measured in all pixels.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Number = TypeVar("Number", bound=np.generic)

NOISE_SAMPLES = 1 << 18
"""Samples of a channel, all frames together, in which temporal noise is measured: a variance is then off by
0.3 % (its margin is 2 %), a correlation by 0.002 (0.004)."""

BAND_ROWS = 16
"""Neighbouring rows that are measured together: correlations reach four rows, mosaics repeat every two."""

CODE_SAMPLES = 1 << 19
"""Samples of all channels and frames that codes are counted in."""

MIDDLE_SAMPLES = 1 << 16
"""Samples that a median is taken of."""


def noise_bands(shape: tuple[int, ...]) -> NDArray[np.int64]:
    """(B, R) rows of frames of a shape (N, H, W, C) for noise: bands spread evenly, or one band of all rows.

    >>> noise_bands((2, 120, 160, 1)).shape, noise_bands((2, 1080, 1920, 3)).shape
    ((1, 120), (5, 16))
    """
    frames, height, width, _ = shape
    bands = max(-(-NOISE_SAMPLES // max(frames * width * BAND_ROWS, 1)), 2)  # one would be the top alone
    if bands * BAND_ROWS >= height:
        return np.arange(height)[None, :]
    first = np.linspace(0, height - BAND_ROWS, bands).astype(np.int64) // 2 * 2
    return np.asarray(first[:, None] + np.arange(BAND_ROWS))


def sampled(values: NDArray[Number], count: int = MIDDLE_SAMPLES) -> NDArray[Number]:
    """(M,) of many values about so many, at equal distances that no rows or channels share a factor with.

    >>> len(sampled(np.zeros((480, 640, 3), np.float32)))
    54212
    """
    flat = values.reshape(-1)
    step = _coprime(max(flat.size // count, 1), values.shape)
    return flat[::step] if step > 1 else flat


def _coprime(step: int, shape: tuple[int, ...]) -> int:
    """The next step from `step` on that shares no factor with sides of an image: all columns come up."""
    while step > 1 and any(np.gcd(step, side) > 1 for side in shape[1:]):
        step += 1
    return step
