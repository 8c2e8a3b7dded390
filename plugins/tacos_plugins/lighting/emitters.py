"""Appearance of light sources: colour of white light, luminance of an emitting surface."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tacos_framework.camera import luminance


def photopic(channels: ArrayLike) -> NDArray[np.float64]:
    """Luminance or illuminance of (..., 3) linear-sRGB channels, in their unit."""
    return luminance(channels)


_SRGB_FROM_XYZ = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
"""Linear sRGB of CIE 1931 tristimulus values (IEC 61966-2-1)."""


def _chromaticity(temperature_k: float) -> tuple[float, float]:
    """CIE 1931 x and y of black bodies below 4000 K, of daylight above, as lamps are labelled.

    Sources: CIE 015:2018, Sec. 4.1.2, for daylight; Kang et al. 2002, "Design of advanced color temperature
    control system for HDTV applications", J. Korean Physical Society 41(6), for black bodies.
    """
    kilo = 1e3 / temperature_k
    if temperature_k >= 4000:
        if temperature_k <= 7000:
            x = 0.244063 + 0.09911 * kilo + 2.9678 * kilo**2 - 4.6070 * kilo**3
        else:
            x = 0.237040 + 0.24748 * kilo + 1.9018 * kilo**2 - 2.0064 * kilo**3
        return x, -3.0 * x**2 + 2.870 * x - 0.275
    x = 0.17991 + 0.8776956 * kilo - 0.2343589 * kilo**2 - 0.2661239 * kilo**3
    if temperature_k <= 2222:
        return x, -1.1063814 * x**3 - 1.34811020 * x**2 + 2.18555832 * x - 0.20219683
    return x, -0.9549476 * x**3 - 1.37418593 * x**2 + 2.09137015 * x - 0.16748867


def white_at(temperature_k: float) -> NDArray[np.float64]:
    """(3,) linear-sRGB channels of white light with a correlated colour temperature, of luminance 1.

    `temperature_k`: correlated colour temperature, 1667 to 25000 [K]. 6504 K gives almost equal channels.
    """
    if not 1667 <= temperature_k <= 25000:
        raise ValueError(f"colour temperature is defined from 1667 to 25000 K, not {temperature_k}")
    # Written out: the library that tests compare this with takes over a second to import, in each worker.
    x, y = _chromaticity(round(float(temperature_k)))
    linear = np.maximum(_SRGB_FROM_XYZ @ [x / y, 1.0, (1 - x - y) / y], 0.0)
    return np.asarray(linear / photopic(linear))


def emitter_luminance_cd_m2(flux_lm: ArrayLike, area_m2: float) -> NDArray[np.float64]:
    """(3,) luminance of a Lambertian emitter that sends its flux from an area [cd/m2].

    A Lambertian emitter of luminance L sends out pi * L per area, so ``L = flux / (pi * area)``.
    """
    if not area_m2 > 0:
        raise ValueError(f"an emitter needs an area above 0, not {area_m2}")
    return np.asarray(flux_lm, dtype=np.float64) / (math.pi * area_m2)
