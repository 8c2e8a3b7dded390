"""Frames as if their lamp had not wavered a little from one to the next.

A lamp that wavers by a part in five hundred is seen in no picture, and is ten times what the variance of all
pixels together varies by. How much it wavers is measured by itself, as `frame_to_frame`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture

WAVER = 0.01
"""Relative deviation of a frame's level that any lamp may have; what is more stays in the noise: flicker."""

LEAST_LIGHT_DN = 1.0
"""Signal below which the light of a frame is not told from its pedestal."""


def levels_of_frames(capture: RealCapture, row_means_dn: NDArray[np.float32]) -> NDArray[np.float32]:
    """(N, 1, C) level of each frame above the pedestal over that of their mean; 1 in the dark.

    At most `WAVER` off 1.

    `row_means_dn`: (N, H, C) means of the rows of the frames, pixels that do not count being 0 [DN].
    """
    if capture.kind == "dark":
        return np.ones((len(row_means_dn), 1, row_means_dn.shape[-1]), np.float32)
    level = row_means_dn.mean(axis=1, keepdims=True, dtype=np.float64) / capture.valid.mean()
    signal = level - capture.context.black_level_dn
    mean = signal.mean(axis=0)
    waver = np.clip((signal - mean) / np.maximum(mean, LEAST_LIGHT_DN), -WAVER, WAVER)
    return np.asarray(1 + waver, np.float32)


def in_steady_light(
    capture: RealCapture, values_dn: NDArray[np.float32], levels: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Values of each frame over the level of its light, above the pedestal [DN].

    `values_dn`: (N, H, W, C) pixels of the frames, or (N, H or W, C) means of their lines [DN]. `levels`: (N,
    1, C) see `levels_of_frames`.
    """
    black = np.float32(capture.context.black_level_dn)
    over = 1 / (levels if values_dn.ndim == 3 else levels[:, :, None])
    return np.asarray(values_dn * over + black * (1 - over), np.float32)
