"""What light sources look like: colour of white light, luminance of an emitting surface."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

LUMINANCE_WEIGHTS = np.array([0.2126, 0.7152, 0.0722])
"""Share of each linear-sRGB channel in luminance (IEC 61966-2-1)."""


def photopic(channels: ArrayLike) -> NDArray[np.float64]:
    """Luminance or illuminance of (..., 3) linear-sRGB channels, in their unit."""
    return np.asarray(channels, dtype=np.float64) @ LUMINANCE_WEIGHTS


@lru_cache(maxsize=64)
def _white_at(temperature_k: float) -> tuple[float, float, float]:
    import colour  # slow to import

    # Black bodies below 4000 K, daylight above, as lamps are labelled (CIE 15).
    method = "CIE Illuminant D Series" if temperature_k >= 4000 else "Kang 2002"
    xy = colour.CCT_to_xy(temperature_k, method=method)
    linear = np.maximum(colour.XYZ_to_RGB(colour.xy_to_XYZ(xy), "sRGB"), 0.0)
    red, green, blue = linear / photopic(linear)
    return float(red), float(green), float(blue)


def white_at(temperature_k: float) -> NDArray[np.float64]:
    """(3,) linear-sRGB channels of white light with a correlated colour temperature, of luminance 1.

    Parameters
    ----------
    temperature_k
        Correlated colour temperature, 1667 to 25000 [K]. 6504 K gives almost equal channels.
    """
    if not 1667 <= temperature_k <= 25000:
        raise ValueError(f"colour temperature is defined from 1667 to 25000 K, not {temperature_k}")
    return np.array(_white_at(round(float(temperature_k))))


def emitter_luminance_cd_m2(flux_lm: ArrayLike, area_m2: float) -> NDArray[np.float64]:
    """(3,) luminance of a Lambertian emitter that sends its flux from an area [cd/m2].

    A Lambertian emitter of luminance L sends out pi * L per area, so ``L = flux / (pi * area)``.
    """
    if not area_m2 > 0:
        raise ValueError(f"an emitter needs an area above 0, not {area_m2}")
    return np.asarray(flux_lm, dtype=np.float64) / (math.pi * area_m2)
