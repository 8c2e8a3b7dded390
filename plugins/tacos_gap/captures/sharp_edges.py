"""Sharp edges in place of blurred ones: the expectation of captures that have none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.capture import RealCapture

REACH_PX = 21
"""Window in which the two sides of an edge are looked for [px]."""

_LEAST_CONTRAST = 0.12
"""Contrast of a window, over that of the image, below which it holds no edge."""


def with_sharp_edges(capture: RealCapture) -> RealCapture:
    """The capture with step edges expected where its frames cross the middle between their two sides.

    Symmetric blur moves no such crossing, so the steps stand where the edges of the world do. What is not
    near an edge is left out by the mask.
    """
    import cv2

    mean = capture.real_dn.mean(axis=0)
    window = np.ones((REACH_PX, REACH_PX), np.uint8)
    planes, near = [], np.ones(mean.shape[:2], bool)
    for channel in range(mean.shape[-1]):
        plane: NDArray[np.float32] = np.ascontiguousarray(cv2.medianBlur(mean[..., channel], 3))
        high = cv2.blur(cv2.dilate(plane, window), (REACH_PX, REACH_PX))
        low = cv2.blur(cv2.erode(plane, window), (REACH_PX, REACH_PX))
        contrast = high - low
        planes.append(np.where(plane > (high + low) / 2, high, low))
        near &= contrast > _LEAST_CONTRAST * max(float(np.ptp(plane)), 1.0)
    expected = np.stack(planes, axis=-1).astype(np.float32)[None]
    return replace(capture, expected_dn=expected, valid=capture.valid & near, own_edges=True)
