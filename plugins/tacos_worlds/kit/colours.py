"""Colours people paint and furnish rooms with, as linear-sRGB reflectance."""

from __future__ import annotations

import colorsys

import numpy as np

Colour = tuple[float, float, float]


def linear(srgb: Colour) -> Colour:
    """Linear reflectance of sRGB values in 0..1 (IEC 61966-2-1)."""
    red, green, blue = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in srgb)
    return red, green, blue


def muted(
    rng: np.random.Generator,
    *,
    saturation: tuple[float, float] = (0.12, 0.5),
    value: tuple[float, float] = (0.35, 0.85),
) -> Colour:
    """An sRGB colour of dyed cloth or paint: mostly warm or blue-green, seldom pink or violet."""
    hues = [rng.normal(0.08, 0.03), rng.normal(0.58, 0.05), rng.normal(0.36, 0.06), rng.normal(0.02, 0.02)]
    hue = rng.choice(hues, p=[0.42, 0.25, 0.10, 0.23])
    return colorsys.hsv_to_rgb(float(hue) % 1.0, float(rng.uniform(*saturation)), float(rng.uniform(*value)))


def vivid(rng: np.random.Generator) -> Colour:
    hue = float(rng.choice([0.0, 0.08, 0.14, 0.33, 0.48, 0.58, 0.64, 0.9]))
    return colorsys.hsv_to_rgb(hue, float(rng.uniform(0.65, 0.9)), float(rng.uniform(0.65, 0.95)))


def whitish(rng: np.random.Generator) -> Colour:
    return colorsys.hsv_to_rgb(
        float(rng.normal(0.1, 0.03)) % 1.0, float(rng.uniform(0.0, 0.09)), float(rng.uniform(0.88, 0.96))
    )
