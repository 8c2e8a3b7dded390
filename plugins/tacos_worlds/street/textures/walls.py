"""Walls of buildings before their windows: brick, render, stone, concrete.

A wall is drawn in cells, one bay by one floor; fronts are scaled so that whole cells fit the building, and
their texture coordinates count cells, not metres. The metres below hold for a cell of `CELL_M`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_worlds.kit.textures.noise import fractal, smoothstep

CELLS = 4
"""Bays and floors of a tile."""
CELL_M = 3.2
"""Edge of a cell, about [m]."""

Image = NDArray[np.float64]
Colour = tuple[float, float, float]


@dataclass
class Canvas:
    """A wall being drawn, rows from the bottom up."""

    colour: Image  # (T, T, 3) sRGB in 0..1
    height_m: Image  # (T, T) relief [m]

    def rectangle(self, u: tuple[float, float], v: tuple[float, float]) -> tuple[slice, slice]:
        """The texels of a rectangle, in cells."""
        scale = len(self.colour) / CELLS
        (u0, u1), (v0, v1) = (tuple(round(x * scale) for x in span) for span in (u, v))
        return slice(v0, max(v1, v0 + 1)), slice(u0, max(u1, u0 + 1))

    def fill(self, u: tuple[float, float], v: tuple[float, float], colour: Colour, height_m: float) -> None:
        """Paint a rectangle flat, in cells."""
        place = self.rectangle(u, v)
        self.colour[place] = colour
        self.height_m[place] = height_m

    def shade(self, u: tuple[float, float], v: tuple[float, float], factor: float) -> None:
        """Darken or lighten a rectangle, in cells."""
        self.colour[self.rectangle(u, v)] *= factor


def brick(rng: np.random.Generator, size: int) -> Canvas:
    columns, rows = 12 * CELLS, 40 * CELLS
    v = np.arange(size)[:, None] / size * rows
    u = (np.arange(size)[None, :] / size * columns + 0.5 * (np.floor(v) % 2)) % columns
    number = (np.floor(v) * columns + np.floor(u)).astype(int)
    tone = rng.normal(0, 0.085, columns * rows)[number]
    joint = np.maximum((u % 1) > 0.92, (v % 1) > 0.72)
    shade = 0.80 + tone + 0.03 * fractal(rng, size, exponent=1.2) + 0.03 * fractal(rng, size, exponent=0.2)
    colour = shade[..., None] * np.where(joint[..., None], [0.97, 0.98, 1.0], [1.0, 0.95, 0.92])
    return Canvas(colour, np.where(joint, -0.006, 0.0))


def render(rng: np.random.Generator, size: int) -> Canvas:
    """Painted render with streaks where water runs down."""
    streaks = fractal(rng, size, exponent=1.0, stretch=(0.15, 1.0)) * 0.022
    shade = (
        0.93 + streaks + 0.018 * fractal(rng, size, exponent=1.5) + 0.016 * fractal(rng, size, exponent=0.1)
    )
    return Canvas(np.repeat(shade[..., None], 3, axis=2), 0.002 * fractal(rng, size, exponent=0.2))


def ashlar(rng: np.random.Generator, size: int) -> Canvas:
    columns, rows = 4 * CELLS, 8 * CELLS
    v = np.arange(size)[:, None] / size * rows
    u = (np.arange(size)[None, :] / size * columns + 0.5 * (np.floor(v) % 2)) % columns
    tone = rng.normal(0, 0.03, columns * rows)[(np.floor(v) * columns + np.floor(u)).astype(int)]
    edge = np.minimum(np.minimum(u % 1, 1 - u % 1) * 2, np.minimum(v % 1, 1 - v % 1))
    joint = 1 - smoothstep(edge, 0.02, 0.07)
    shade = 0.86 + tone + 0.03 * fractal(rng, size, exponent=1.1) + 0.02 * fractal(rng, size, exponent=0.1)
    colour = (shade - 0.2 * joint)[..., None] * np.array([1.0, 0.965, 0.9])
    return Canvas(colour, -0.012 * joint)


def concrete(rng: np.random.Generator, size: int) -> Canvas:
    """Precast panels, one a cell, with joints and weathering from above."""
    cell = np.arange(size) / size * CELLS % 1
    edge = np.minimum(np.minimum(cell, 1 - cell)[None, :], np.minimum(cell, 1 - cell)[:, None])
    joint = 1 - smoothstep(edge, 0.004, 0.014)
    number = (np.arange(size) * CELLS // size)[:, None] * CELLS + (np.arange(size) * CELLS // size)[None, :]
    shade = 0.74 + rng.normal(0, 0.025, CELLS * CELLS)[number] + 0.03 * fractal(rng, size, exponent=1.3)
    shade += 0.025 * fractal(rng, size, exponent=0.7, stretch=(0.2, 1.0)) + 0.015 * fractal(
        rng, size, exponent=0.0
    )
    return Canvas((shade - 0.35 * joint)[..., None] * np.array([0.99, 1.0, 1.0]), -0.015 * joint)


WALLS = {"brick": brick, "render": render, "ashlar": ashlar, "concrete": concrete}
