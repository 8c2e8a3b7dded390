from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray


def over_frames(frames: NDArray[np.float32]) -> NDArray[np.float32]:
    """(H, W, C) mean of (N, H, W, C) frames."""
    count = len(frames)
    if count == 1:
        return frames[0]
    return np.asarray(np.full(count, 1 / count, np.float32) @ frames.reshape(count, -1)).reshape(
        frames.shape[1:]
    )


def over_channels(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """(H, W) mean of the channels of an (H, W, C) image."""
    channels = image.shape[-1]
    return np.asarray(image @ np.full(channels, 1 / channels, np.float32))


def line_means(image: NDArray[np.float32], axis: int) -> NDArray[np.float32]:
    """(W, C) means of the columns of an (H, W, C) image for axis 0, (H, C) means of its rows for axis 1."""
    height, width, channels = image.shape
    samples = np.ascontiguousarray(image).reshape(height, width * channels)
    if axis == 0:
        return np.asarray(np.full(height, 1 / height, np.float32) @ samples).reshape(width, channels)
    return np.asarray(samples @ _along_rows(width, channels))


def line_means_of_frames(frames: NDArray[np.float32], axis: int) -> NDArray[np.float32]:
    """(N, W or H, C) `line_means` of each of (N, H, W, C) frames."""
    return np.stack([line_means(frame, axis) for frame in frames])


def over_image(image: NDArray[np.float32]) -> NDArray[np.float64]:
    """(C,) mean of each channel of an (H, W, C) image."""
    return np.asarray(line_means(image, 1).mean(axis=0, dtype=np.float64))


@lru_cache(maxsize=8)
def _along_rows(width: int, channels: int) -> NDArray[np.float32]:
    """(W C, C) what takes the mean of each channel along a row."""
    return np.tile(np.eye(channels, dtype=np.float32) / np.float32(width), (width, 1))
