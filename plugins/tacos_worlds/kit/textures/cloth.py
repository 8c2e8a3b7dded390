"""Cloth, carpet and leather; mostly pale, so that a material's base colour can dye them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_worlds.kit.colours import muted
from tacos_worlds.kit.textures.noise import fractal, smoothstep
from tacos_worlds.kit.textures.texture import Texture, blend, texels_near, texture


def _threads(rng: np.random.Generator, size: int, count: int) -> NDArray[np.float64]:
    """(size, size) height 0..1 of a plain weave of `count` (even) threads each way, unevenly thick."""
    position = np.arange(size) / size * count
    wobble = 0.12 * fractal(rng, size, exponent=1.2, highest=40)
    u, v = position[None, :] + wobble, position[:, None] + wobble.T
    over = np.where(
        (np.floor(u) + np.floor(v)) % 2 == 0, np.abs(np.sin(np.pi * v)), np.abs(np.sin(np.pi * u))
    )
    thickness = rng.normal(1, 0.12, count)
    uneven = thickness[np.floor(u).astype(int) % count] * thickness[np.floor(v).astype(int) % count]
    return np.asarray(over * uneven)


def weave(rng: np.random.Generator, size: int) -> Texture:
    """Coarse upholstery weave, 0.25 m of it."""
    height = _threads(rng, size, 48)
    melange = fractal(rng, size, exponent=0.6, stretch=(1.0, 5.0)) + fractal(
        rng, size, exponent=0.6, stretch=(5.0, 1.0)
    )
    shade = 0.66 + 0.22 * height + 0.05 * melange + 0.025 * fractal(rng, size, exponent=1.5)
    return texture(shade, 0.25, height_m=height * 8e-4)


def linen(rng: np.random.Generator, size: int) -> Texture:
    """Fine linen with soft folds, 0.5 m of it."""
    slubs = fractal(rng, size, exponent=0.5, stretch=(12.0, 1.0)) + fractal(
        rng, size, exponent=0.5, stretch=(1.0, 12.0)
    )
    folds = fractal(rng, size, exponent=2.0, highest=10)
    shade = 0.86 + 0.035 * slubs + 0.03 * folds
    return texture(shade, 0.5, height_m=folds * 2.5e-3 + slubs * 1e-4)


def knit(rng: np.random.Generator, size: int) -> Texture:
    """Chunky knit in columns of stitches, 0.3 m of it."""
    columns, rows = 16, 24
    u = np.arange(size)[None, :] / size * columns
    v = np.arange(size)[:, None] / size * rows
    side = np.abs(u % 1 - 0.5) * 2
    stitch = np.abs(np.sin(np.pi * (v + side * 0.8)))
    height = stitch * (1 - 0.75 * side**3)
    shade = 0.55 + 0.36 * height + 0.04 * fractal(rng, size, exponent=0.5)
    return texture(shade, 0.3, height_m=height * 2.5e-3)


def plaid(rng: np.random.Generator, size: int) -> Texture:
    """Tartan of three colours, 0.5 m of it."""
    base, second, third = (np.array(muted(rng, saturation=(0.1, 0.6))) for _ in range(3))
    width = rng.uniform(0.12, 0.3, 2)
    line = np.arange(size) / size
    broad = smoothstep(
        np.cos(2 * np.pi * line), np.cos(np.pi * width[0] * 2) - 0.02, np.cos(np.pi * width[0] * 2) + 0.02
    )
    fine = smoothstep(np.cos(2 * np.pi * (line * 2 + 0.31)), 0.93, 0.97)
    twill = ((np.arange(size)[:, None] + np.arange(size)[None, :]) // 2 % 2).astype(float)
    colour = np.broadcast_to(base, (size, size, 3)).copy()
    for stripe, ink in ((broad, second), (fine, third)):
        colour = blend(colour, ink, np.broadcast_to(stripe[None, :], (size, size)) * (0.35 + 0.3 * twill))
        colour = blend(colour, ink, np.broadcast_to(stripe[:, None], (size, size)) * (0.65 - 0.3 * twill))
    return texture(colour * (0.95 + 0.04 * fractal(rng, size, exponent=0.7)[..., None]), 0.5)


def stripes(rng: np.random.Generator, size: int) -> Texture:
    """Striped cotton along u, 0.4 m of it."""
    count = int(rng.integers(4, 9))
    inks = np.array([muted(rng, saturation=(0.05, 0.45), value=(0.4, 0.95)) for _ in range(3)])
    ink_of = rng.integers(0, 3, count * 2)
    band = ink_of[(np.arange(size) * count * 2 // size)]
    colour = np.repeat(inks[band][:, None, :], size, axis=1)
    grain = 0.94 + 0.04 * fractal(rng, size, exponent=0.5) + 0.03 * _threads(rng, size, 64)
    return texture(colour * grain[..., None], 0.4)


def blossoms(rng: np.random.Generator, size: int) -> Texture:
    """Printed flowers on plain cloth, 0.5 m of it."""
    ground = np.array(muted(rng, saturation=(0.03, 0.15), value=(0.82, 0.95)))
    leaf = np.array([0.35, 0.48, 0.30]) * rng.uniform(0.8, 1.2, 3)
    colour = np.broadcast_to(ground, (size, size, 3)).copy()
    for _ in range(26):
        u, v, radius, turn = *rng.uniform(0, 1, 2), rng.uniform(0.03, 0.075), rng.uniform(0, 6.28)
        at = np.ix_(texels_near(v, 1.1 * radius, size), texels_near(u, 1.1 * radius, size))
        dv, du = (at[0] / size - v + 0.5) % 1 - 0.5, (at[1] / size - u + 0.5) % 1 - 0.5
        distance, angle = np.hypot(du, dv) / radius, np.arctan2(dv, du) + turn
        petals = int(rng.integers(4, 8))
        outline = 0.7 + 0.3 * np.cos(angle * petals)
        flower = 1 - smoothstep(distance / outline, 0.9, 1.05)
        ink = leaf if rng.uniform() < 0.35 else np.array(muted(rng, saturation=(0.25, 0.65)))
        petal = blend(colour[at], ink, flower)
        colour[at] = blend(petal, ink * 0.5, 1 - smoothstep(distance, 0.18, 0.26))
    return texture(colour * (0.97 + 0.02 * fractal(rng, size, exponent=0.5)[..., None]), 0.5)


def pile(rng: np.random.Generator, size: int) -> Texture:
    """Carpet pile, 0.5 m of it: tufts, tread marks, speckles."""
    tufts = fractal(rng, size, exponent=-0.4, lowest=20, highest=90)
    tread = fractal(rng, size, exponent=1.8, highest=12)
    shade = 0.74 + 0.085 * tufts + 0.045 * tread
    return texture(shade, 0.5, height_m=tufts * 6e-4)


def rug(rng: np.random.Generator, size: int) -> Texture:
    """A woven rug's field: diamonds within diamonds, 1 m of it."""
    inks = np.array(
        [[0.55, 0.16, 0.13], [0.16, 0.20, 0.34], [0.80, 0.70, 0.52], [0.25, 0.30, 0.24], [0.87, 0.83, 0.76]]
    )
    inks = np.clip(inks[rng.permutation(5)] * rng.uniform(0.93, 1.07, 3), 0, 1)
    cells = int(rng.choice([2, 4]))
    knots = 128
    grid = np.arange(size) * knots // size
    u = (grid[None, :] * cells / knots) % 1 - 0.5
    v = (grid[:, None] * cells / knots) % 1 - 0.5
    diamond = np.abs(u) + np.abs(v) + 0.05 * np.cos(12 * np.pi * (np.abs(u) - np.abs(v)))
    band = np.floor(np.clip(diamond, 0, 0.999) * rng.integers(7, 12)).astype(int)
    zigzag = (np.floor((np.abs(u) * 2 + np.abs(v)) * 16) % 3 == 0).astype(int)
    colour = inks[(band + zigzag * (band % 2)) % 5]
    abrash = 0.05 * fractal(rng, size, exponent=1.4, stretch=(8.0, 1.0))
    grain = 0.93 + abrash + 0.06 * fractal(rng, size, exponent=-0.2, lowest=24)
    return texture(colour * grain[..., None], 1.0)


def leather(rng: np.random.Generator, size: int) -> Texture:
    """Grained leather with creases, 0.4 m of it."""
    cells = np.abs(fractal(rng, size, exponent=0.3, lowest=16, highest=56))
    creases = smoothstep(np.abs(fractal(rng, size, exponent=1.3, lowest=3, highest=30)), 0.0, 0.12)
    height = smoothstep(cells, 0.0, 0.5) * 0.6 + creases * 0.4
    shade = 0.62 + 0.24 * height + 0.035 * fractal(rng, size, exponent=1.6)
    return texture(shade, 0.4, height_m=height * 5e-4)
