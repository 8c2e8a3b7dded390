"""Mean reflectance of a material."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera.colour import LINEAR_OF_SRGB_BYTE
from tacos_framework.values import Material


def mean_reflectance(material: Material) -> NDArray[np.float64]:
    """(3,) reflectance per linear-sRGB channel, averaged over the texture [1]."""
    tint = material.base_colour.astype(np.float64)
    if material.texture is None:
        return tint
    counts = [np.bincount(material.texture[..., channel].ravel(), minlength=256) for channel in range(3)]
    return tint * (np.array(counts) @ LINEAR_OF_SRGB_BYTE) / material.texture[..., 0].size
