"""Blur of a pixel or two at little cost, for frames of a study."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_plugins.effects.blur import blur
from tacos_plugins.effects.disc import disc_kernel

SLIGHT_PX = 2.0
"""Radius up to which near things hardly reach over what lies behind, so that no layers are needed [px]."""

_FINEST_PX = 0.4
_PASSES = 2
_AS_GOOD = 1e-3
"""Share of the largest singular value below which those of a kernel are left out: its transfer stays within
0.005."""


def blur_slightly(light: NDArray[np.floating], radius_px: NDArray[np.floating]) -> NDArray[np.floating]:
    """Light that each pixel gathers over a disc of its own.

    Discs between two widths are mixtures of these with the right variance, so that what is sharp beside an
    edge in depth stays so.

    `light`: (N, H, W, C) float32 or float64. `radius_px`: (N, H, W) radius of each pixel's disc; negative
    before the focus [px].
    """
    square = np.asarray(radius_px**2, light.dtype)[..., None]
    steps = [math.sqrt(float(square.max()))]
    while steps[0] > _FINEST_PX:
        steps.insert(0, steps[0] / 2)
    mixed, narrower, inner = light, light, 0.0
    for step in steps:
        wider = blur(light, disc_kernel(step))
        share = np.clip((square - inner) / (step**2 - inner), 0, 1)
        mixed = mixed + share * (wider - narrower)
        narrower, inner = wider, step**2
    return mixed


def blur_in_two_passes(light: NDArray[np.floating], kernel: NDArray[np.float64]) -> NDArray[np.floating]:
    """`blur` by a (K, K) kernel, as two products of a column and a row where that keeps its transfer."""
    columns, sizes, rows = np.linalg.svd(kernel)
    if sizes[_PASSES] > _AS_GOOD * sizes[0]:
        return blur(light, kernel)
    parts = [(columns[:, i] * sizes[i], rows[i]) for i in range(_PASSES)]
    total = sum(column.sum() * row.sum() for column, row in parts)
    blurred = np.empty_like(light)
    for frame, out in zip(light, blurred, strict=True):
        one, other = (
            cv2.sepFilter2D(frame, -1, row, column / total, borderType=cv2.BORDER_REPLICATE)
            for column, row in parts
        )
        np.clip((one + other).reshape(frame.shape), frame.min(), frame.max(), out=out)
    return blurred
