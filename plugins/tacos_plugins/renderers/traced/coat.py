"""The coat that the rasterizer gives smooth dielectrics."""

from __future__ import annotations

import numpy as np

from tacos_framework import Material

MATTE_ROUGHNESS = 0.8
"""Dielectrics at least this rough are Lambertian [1]."""

_SHEEN_RANGE = 0.4  # of roughness below that, over which the coat grows to its full strength


def sheen(material: Material) -> float:
    """Strength of a dielectric's coat, 0..1 [1].

    >>> grey = np.full(3, 0.5)
    >>> [round(sheen(Material("m", grey, roughness=r)), 6) for r in (0.3, 0.6, 0.9)]
    [1.0, 0.5, 0.0]
    """
    return float(np.clip((MATTE_ROUGHNESS - material.roughness) / _SHEEN_RANGE, 0.0, 1.0))
