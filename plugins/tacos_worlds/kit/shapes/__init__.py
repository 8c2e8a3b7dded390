"""Parametric solids that furniture and structure are made of."""

from __future__ import annotations

from tacos_worlds.kit.shapes.boxes import box, cushion, slab
from tacos_worlds.kit.shapes.lofts import disc_stack, loft, superellipse, tube
from tacos_worlds.kit.shapes.surfaces import extruded, panel, sheet

__all__ = [
    "box",
    "cushion",
    "disc_stack",
    "extruded",
    "loft",
    "panel",
    "sheet",
    "slab",
    "superellipse",
    "tube",
]
