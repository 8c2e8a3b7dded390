"""One picture laid over another by the affine map that aligns them.

A blurred picture aligns badly with a sharp one, since what both show are different edges. So a hypothesis is
laid over the real frames *after* its effects, when both are as sharp as each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.effects.alignment import aligned

BORDER_PX = 4
"""Rim that is not compared: there a picture is what interpolation makes of its edge [px]."""


@dataclass(frozen=True, eq=False)
class Overlay:
    """A picture in the pixels of another."""

    image: NDArray[np.float32]  # (H, W) float32 the moved picture
    inside: NDArray[np.bool_]  # (H, W) bool where it is known


def laid_over(picture: NDArray[np.float32], onto: NDArray[np.float32]) -> Overlay | None:
    """The picture moved by the affine map that correlates it best with another; None where nothing does.

    Gains and offsets do not matter.
    """
    import cv2

    matrix = aligned(_unit(onto), _unit(picture))
    if matrix is None:
        return None
    size = picture.shape[::-1]
    back = cv2.WARP_INVERSE_MAP
    moved = cv2.warpAffine(
        picture, matrix, size, flags=cv2.INTER_LANCZOS4 | back, borderMode=cv2.BORDER_REPLICATE
    )
    rim = np.zeros(picture.shape, np.float32)
    rim[BORDER_PX:-BORDER_PX, BORDER_PX:-BORDER_PX] = 1
    seen = cv2.warpAffine(rim, matrix, size, flags=cv2.INTER_NEAREST | back)
    return Overlay(np.asarray(moved, np.float32), np.asarray((seen > 0) & (rim > 0)))


def _unit(image: NDArray[np.float32]) -> NDArray[np.float32]:
    low, high = float(image.min()), float(image.max())
    return np.ascontiguousarray((image - low) / max(high - low, 1e-6), np.float32)
