"""Mean reflectance of materials."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Material
from tacos_framework.camera import LINEAR_OF_SRGB_BYTE


def mean_reflectances(materials: Sequence[Material]) -> NDArray[np.float64]:
    """(materials, 3) reflectance per linear-sRGB channel, averaged over each texture [1]."""
    sums: dict[int, NDArray[np.float64]] = {}  # by texture, as many materials are tints of one
    found = []
    for material in materials:
        tint, image = material.base_colour.astype(np.float64), material.texture
        if image is not None:
            if id(image) not in sums:
                sums[id(image)] = _summed(image)
            tint = tint * sums[id(image)] / image[..., 0].size
        found.append(tint)
    return np.array(found).reshape(-1, 3)


def _summed(image: NDArray[np.uint8]) -> NDArray[np.float64]:
    """(3,) sums of the reflectances that all pixels of an image stand for [1]."""
    counts = [cv2.calcHist([image], [channel], None, [256], [0, 256]).ravel() for channel in range(3)]
    return np.asarray(np.array(counts, np.float64) @ LINEAR_OF_SRGB_BYTE)
