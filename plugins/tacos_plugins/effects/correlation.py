"""Mixing neighbouring samples by a small kernel."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray


def correlate(frames: NDArray[np.floating], kernel: NDArray[np.float64]) -> NDArray[np.floating]:
    """Correlate every frame and channel with a kernel; beyond the edges the image is mirrored.

    `frames`: (N, H, W, C) samples, C at most 4. `kernel`: (K, K) weights, K odd.

    Returns: same shape and dtype.

    >>> spike = np.zeros((1, 3, 3, 1))
    >>> spike[0, 1, 1, 0] = 9.0
    >>> correlate(spike, np.full((3, 3), 1 / 9))[0, :, :, 0].round(9).tolist()
    [[1.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 1.0]]
    """
    mixed = np.empty_like(frames)
    for frame, out in zip(frames, mixed, strict=True):
        out[:] = cv2.filter2D(frame, -1, kernel, borderType=cv2.BORDER_REFLECT).reshape(out.shape)
    return mixed
