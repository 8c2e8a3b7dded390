"""Outlines of masks, as COCO has them."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray


def polygons(mask: NDArray[np.bool_]) -> list[list[float]]:
    """Outlines of the pieces of a mask: x, y, x, y, ... by edges of pixels [px].

    A list of polygons is their union, so that a hole is joined to its piece by a slit of no width. Outlines
    lie a quarter of a pixel inside the mask: whoever fills them gets it back, however they are rounded.

    >>> polygons(np.array([[0, 0], [0, 1]], bool))
    [[1.25, 1.25, 1.25, 1.75, 1.75, 1.75, 1.75, 1.25]]
    """
    halves = mask.astype(np.uint8).repeat(2, axis=0).repeat(2, axis=1)
    contours, levels = cv2.findContours(halves, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    rings = [(contour[:, 0] + 0.5) / 2 for contour in contours]
    found = []
    for index, ring in enumerate(rings):
        _, _, hole, around = levels[0][index]
        if around >= 0:  # a hole itself
            continue
        pieces = [ring]
        while hole >= 0:
            pieces += [ring[:1], rings[hole], rings[hole][:1]]
            hole = levels[0][hole][0]
        found.append(np.concatenate(pieces).ravel().tolist())
    return found
