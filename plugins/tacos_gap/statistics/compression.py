"""Traces of 8 x 8 block codecs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dctn

from tacos_gap.statistics.block import Sample, StatisticBlock

BLOCK_PX = 8
LARGEST_PX = 384
"""Side of the middle of an image in which blocks are looked for: a codec treats all of them alike [px]."""

_OUTLIERS = 0.1
"""Share of lines left out at either end: one bad column is no codec."""


def compression_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Steps at borders of 8 x 8 blocks over steps elsewhere, and vanished coefficients of blocks in place."""
    channel = 1 if len(sample.channels) == 3 else 0
    if min(sample.valid.shape) < 6 * BLOCK_PX:
        return
    middle = _middle(sample.valid.shape)
    frame = np.ascontiguousarray(sample.files[0][..., channel][middle])
    residual = frame - sample.expected[0][..., channel][middle]
    steps = [_border_steps(residual), _border_steps(residual.T)]
    at = [{"direction": "columns"}, {"direction": "rows"}]
    yield StatisticBlock("block_borders", "codec", np.array(steps), at, 0.02)
    vanished = _vanished(frame, 0) - _vanished(frame, 4)
    yield StatisticBlock(
        "vanished_coefficients", "codec", vanished, [{"frequency": "low"}, {"frequency": "high"}], 0.01
    )


def _middle(shape: tuple[int, ...]) -> tuple[slice, slice]:
    """Rows and columns of the middle of an image, from a border of blocks on; all where it is small."""
    first = [max(side - LARGEST_PX, 0) // 2 // BLOCK_PX * BLOCK_PX for side in shape]
    return slice(first[0], first[0] + LARGEST_PX), slice(first[1], first[1] + LARGEST_PX)


def _border_steps(residual: NDArray[np.float32]) -> float:
    steps = np.abs(np.diff(residual, axis=1)).mean(axis=0)
    border = np.arange(len(steps)) % BLOCK_PX == BLOCK_PX - 1
    at_borders, elsewhere = (_trimmed_mean(part) for part in (steps[border], steps[~border]))
    return float(np.log((at_borders + 0.05) / (elsewhere + 0.05)))


def _trimmed_mean(values: NDArray[np.float32]) -> np.floating:
    """Mean without outliers; scipy's `trim_mean` spends most of its time on its arguments."""
    cut = int(_OUTLIERS * len(values))
    return np.partition(values, (cut, len(values) - cut - 1))[cut : len(values) - cut].mean()


def _vanished(frame: NDArray[np.float32], offset: int) -> NDArray[np.float64]:
    """Share of coefficients near 0, of low and of high frequency, in blocks that start at `offset`."""
    part = frame[offset:, offset:]
    height, width = (size // BLOCK_PX * BLOCK_PX for size in part.shape)
    blocks = part[:height, :width].reshape(height // BLOCK_PX, BLOCK_PX, width // BLOCK_PX, BLOCK_PX)
    near_0 = np.abs(dctn(blocks, axes=(1, 3), norm="ortho")) < 0.6
    order = np.add.outer(np.arange(BLOCK_PX), np.arange(BLOCK_PX))
    share = near_0.view(np.uint8).sum(axis=0, dtype=np.uint16).sum(axis=1) / (
        blocks.shape[0] * blocks.shape[2]
    )
    return np.array([share[(order > 0) & (order < 6)].mean(), share[order >= 6].mean()])
