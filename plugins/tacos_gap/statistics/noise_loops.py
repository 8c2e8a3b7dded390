"""Differences of single frames from their mean, compiled; imported late, as numba takes a while."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.compiled.loops import compiled


@compiled
def part_from_mean(
    frames: NDArray[np.float32],
    mean: NDArray[np.float32],
    rows: NDArray[np.int64],
    over: NDArray[np.float32],
    added: NDArray[np.float32],
    scale: np.float32,
    channels: int,
    noise: NDArray[np.float32],
) -> None:
    """Frames times a factor each, less their mean times `scale`, plus a constant each; less means of rows.

    - `frames`: (N, H, S) samples, row by row.
    - `mean`: (H, S) their mean.
    - `rows`: (R,) those that are wanted.
    - `over`, `added`: (N, S) factor and constant of each frame, the same in every row.
    - `channels`: C; a row has the samples of its pixels side by side.
    - `noise`: (N, R, S) is filled.
    """
    for frame in range(len(frames)):
        for place, row in enumerate(rows):
            for k in range(frames.shape[2]):
                scaled = frames[frame, row, k] * over[frame, k]
                noise[frame, place, k] = scaled - scale * mean[row, k] + added[frame, k]
            for channel in range(channels):
                total = 0.0
                for k in range(channel, frames.shape[2], channels):
                    total += noise[frame, place, k]
                shared = np.float32(total * channels / frames.shape[2])
                for k in range(channel, frames.shape[2], channels):
                    noise[frame, place, k] -= shared
