"""Ground: asphalt, slabs, kerbstones, grass, worn paint."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_worlds.kit.textures.noise import fractal, smoothstep
from tacos_worlds.kit.textures.texture import Texture, blend, texture


def _grey(shade: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.repeat(shade[..., None], 3, axis=2)


def _cracks(rng: np.random.Generator, size: int, count: int) -> NDArray[np.float64]:
    """(size, size) 1 on wandering thin cracks, 0 elsewhere; they run on across the tile's edges."""
    canvas = np.zeros((size, size), np.uint8)
    for _ in range(count):
        at, heading = rng.uniform(0, size, 2), rng.uniform(0, 2 * np.pi)
        for _ in range(int(rng.integers(12, 50))):
            heading += rng.normal(0, 0.22)
            to = at + 5 * np.array([np.cos(heading), np.sin(heading)])
            for shift_x in (-size, 0, size):
                for shift_y in (-size, 0, size):
                    (x0, y0), (x1, y1) = (np.rint(p).astype(int).tolist() for p in (at, to))
                    begin, end = (x0 + shift_x, y0 + shift_y), (x1 + shift_x, y1 + shift_y)
                    cv2.line(canvas, begin, end, 255, 1, cv2.LINE_AA)
            at = to % size
    return canvas / 255.0


def asphalt(rng: np.random.Generator, size: int) -> Texture:
    """Worn asphalt, 7 m of it: stones, stains, repaired patches and tarred cracks."""
    stones = fractal(rng, size, exponent=0.0)
    worn = fractal(rng, size, exponent=1.3, lowest=1)
    stains = smoothstep(fractal(rng, size, exponent=1.6, highest=20), 1.0, 2.4)
    shade = 0.44 + 0.045 * stones + 0.03 * worn - 0.07 * stains
    shade += 0.14 * (fractal(rng, size, exponent=0.0) > 2.0)
    for _ in range(3):
        u, v = rng.integers(0, size, 2)
        w, h = rng.integers(size // 14, size // 4, 2)
        rows, columns = (v + np.arange(h)) % size, (u + np.arange(w)) % size
        shade[np.ix_(rows, columns)] += rng.uniform(-0.06, 0.035)
    shade -= 0.11 * _cracks(rng, size, 6)
    colour = _grey(shade) * np.array([1.0, 0.99, 0.97])
    return texture(colour, 7.0, height_m=0.004 * stones)


def slabs(rng: np.random.Generator, size: int) -> Texture:
    """Concrete paving, 4 m of it: staggered slabs of 0.5 m that differ, with joints, gum and stains."""
    count = 8
    v = np.arange(size)[:, None] / size * count
    u = (np.arange(size)[None, :] / size * count + 0.5 * (np.floor(v) % 2)) % count
    number = (np.floor(v) * count + np.floor(u)).astype(int)
    edge = np.minimum(np.minimum(u % 1, 1 - u % 1), np.minimum(v % 1, 1 - v % 1)) * size / count
    joint = 1 - smoothstep(edge, 0.6, 1.9)
    tone = rng.normal(0, 0.035, count * count)[number]
    grain = fractal(rng, size, exponent=0.1)
    stains = fractal(rng, size, exponent=1.6, highest=24)
    gum = smoothstep(fractal(rng, size, exponent=0.4, highest=90), 2.7, 3.1)
    shade = 0.66 + tone + 0.025 * grain + 0.03 * stains - 0.22 * joint - 0.2 * gum
    return texture(_grey(shade) * np.array([1.0, 0.98, 0.94]), 4.0, height_m=-0.006 * joint)


def kerbstone(rng: np.random.Generator, size: int) -> Texture:
    """Granite kerbs, 2 m of them: speckled stones a metre long."""
    along = np.arange(size)[None, :] / size * 2
    joint = np.broadcast_to(1 - smoothstep(np.minimum(along % 1, 1 - along % 1), 0.006, 0.014), (size, size))
    shade = 0.68 + 0.06 * fractal(rng, size, exponent=0.0) + 0.035 * fractal(rng, size, exponent=1.4)
    return texture(_grey(shade - 0.25 * joint), 2.0)


def grass(rng: np.random.Generator, size: int) -> Texture:
    """A lawn, 5 m of it: blades, tufts and bare patches."""
    blades = fractal(rng, size, exponent=0.1, stretch=(1.0, 1.6))
    tufts = fractal(rng, size, exponent=1.1, lowest=3)
    dry = smoothstep(fractal(rng, size, exponent=1.5, highest=14), 0.3, 2.2)
    colour = blend((0.24, 0.36, 0.15), (0.42, 0.49, 0.22), np.clip(0.5 + 0.22 * blades + 0.16 * tufts, 0, 1))
    return texture(blend(colour, (0.52, 0.48, 0.30), 0.7 * dry), 5.0)


def paint(rng: np.random.Generator, size: int) -> Texture:
    """Worn white road paint, 3 m of it: asphalt shows through."""
    wear = fractal(rng, size, exponent=0.9) + 0.6 * fractal(rng, size, exponent=0.0)
    shade = 0.88 + 0.02 * fractal(rng, size, exponent=0.2) - 0.36 * smoothstep(wear, 1.3, 2.6)
    return texture(_grey(shade), 3.0)


def gravel(rng: np.random.Generator, size: int) -> Texture:
    """Roofing felt with grit, 6 m of it: overlapping strips and puddle stains."""
    along = np.arange(size)[:, None] / size * 6
    seam = np.broadcast_to(1 - smoothstep(np.minimum(along % 1, 1 - along % 1), 0.01, 0.03), (size, size))
    shade = (
        0.47 + 0.05 * fractal(rng, size, exponent=0.0) + 0.05 * fractal(rng, size, exponent=1.5, highest=30)
    )
    return texture(_grey(shade - 0.12 * seam), 6.0)


def roof_tiles(rng: np.random.Generator, size: int) -> Texture:
    """Clay pantiles, 4 m of them."""
    columns, rows = 16, 12
    u = np.arange(size)[None, :] / size * columns
    v = np.arange(size)[:, None] / size * rows
    tone = rng.normal(0, 0.07, columns * rows)[(np.floor(v) * columns + np.floor(u)).astype(int)]
    wave = np.broadcast_to(0.5 + 0.5 * np.sin(2 * np.pi * u), (size, size))
    lap = np.broadcast_to(smoothstep(v % 1, 0.0, 0.2), (size, size))
    shade = (0.72 + tone + 0.04 * fractal(rng, size, exponent=0.6)) * (0.72 + 0.28 * wave) * (0.6 + 0.4 * lap)
    moss = smoothstep(fractal(rng, size, exponent=1.4, highest=30), 1.1, 2.3)
    colour = blend(shade[..., None] * np.array([0.86, 0.52, 0.40]), (0.36, 0.38, 0.27), 0.55 * moss)
    return texture(colour, 4.0, height_m=0.02 * wave)
