"""Mean reflectance of a material."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_framework.values import Material

_STEPS = np.arange(256) / 255
_LINEAR = np.where(_STEPS <= 0.04045, _STEPS / 12.92, ((_STEPS + 0.055) / 1.055) ** 2.4)
"""Linear value of each sRGB byte (IEC 61966-2-1)."""


def mean_reflectance(material: Material) -> NDArray[np.float64]:
    """(3,) reflectance per linear-sRGB channel, averaged over the texture [1]."""
    tint = material.base_colour.astype(np.float64)
    if material.texture is None:
        return tint
    counts = [np.bincount(material.texture[..., channel].ravel(), minlength=256) for channel in range(3)]
    return tint * (np.array(counts) @ _LINEAR) / material.texture[..., 0].size
