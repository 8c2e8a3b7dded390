"""Plaster, paper on plaster, tiles, stone, ceramic and metal."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_worlds.kit.colours import muted
from tacos_worlds.kit.textures.noise import fractal, smoothstep
from tacos_worlds.kit.textures.texture import Texture, blend, texture


def plaster(rng: np.random.Generator, size: int) -> Texture:
    """Painted plaster, 2 m of it: roller stipple, trowel marks, faint stains and scuffs."""
    stipple = fractal(rng, size, exponent=0.0, lowest=40)
    trowel = fractal(rng, size, exponent=1.2, stretch=(2.5, 1.0), lowest=3)
    stains = fractal(rng, size, exponent=1.9, highest=8)
    scuffs = smoothstep(fractal(rng, size, exponent=0.8, stretch=(5.0, 1.0), lowest=5), 2.6, 3.4)
    shade = 0.93 + 0.010 * stipple + 0.012 * trowel + 0.012 * stains - 0.06 * scuffs
    return texture(shade, 2.0, height_m=stipple * 2.5e-4 + trowel * 5e-4)


def woodchip(rng: np.random.Generator, size: int) -> Texture:
    """Painted ingrain wallpaper, 0.8 m of it: chips under paint."""
    chips = smoothstep(fractal(rng, size, exponent=0.2, stretch=(1.4, 1.0), lowest=10, highest=60), 0.8, 2.0)
    stains = fractal(rng, size, exponent=1.9, highest=6)
    shade = 0.90 + 0.05 * chips + 0.008 * stains + 0.008 * fractal(rng, size, exponent=0.3)
    return texture(shade, 0.8, height_m=chips * 9e-4)


def wallpaper(rng: np.random.Generator, size: int) -> Texture:
    """Wallpaper with a printed damask-like ornament, 0.53 m (one roll) of it."""
    row, column = np.indices((size, size)) / size
    repeat = int(rng.choice([2, 3]))
    ornament = np.zeros((size, size))
    for shift in (0.0, 0.5):
        u = (column * repeat + shift) % 1 - 0.5
        v = (row * repeat + shift) % 1 - 0.5
        angle, radius = np.arctan2(v, u), np.hypot(u, v) * 2
        lobes = int(rng.choice([4, 6, 8]))
        outline = 0.42 + 0.16 * np.cos(lobes * angle) + 0.06 * np.cos(3 * lobes * angle + 1.0)
        ornament = np.maximum(ornament, 1 - smoothstep(np.abs(radius - outline), 0.05, 0.09))
        ornament = np.maximum(ornament, 1 - smoothstep(radius, 0.12, 0.16))
    pinstripe = smoothstep(np.cos(2 * np.pi * column * repeat * 4), 0.9, 0.98)
    ground = rng.uniform(0.72, 0.92) * np.array([1.0, 0.97, 0.92]) * rng.uniform(0.94, 1.0, 3)
    ink = ground * rng.uniform(0.62, 0.85) * rng.uniform(0.85, 1.1, 3)
    colour = blend(blend(ground, ink, 0.35 * pinstripe), ink, 0.9 * ornament)
    fade = 1 + 0.012 * fractal(rng, size, exponent=1.6) + 0.012 * fractal(rng, size, exponent=0.1)
    return texture(colour * fade[..., None], 0.53, height_m=ornament * 2e-4)


def _tiles(
    rng: np.random.Generator, size: int, columns: int, rows: int, *, staggered: bool, grout_texels: float
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """(tile number, 1 on tiles and 0 in joints) for a grid of tiles."""
    u = np.arange(size)[None, :] / size * columns
    v = np.arange(size)[:, None] / size * rows
    shift = (np.floor(v) % 2) * 0.5 if staggered else np.zeros_like(v)
    u = (u + shift) % columns
    to_edge_u = np.minimum(u % 1, 1 - u % 1) * size / columns
    to_edge_v = np.minimum(v % 1, 1 - v % 1) * size / rows
    number = (np.floor(v) * columns + np.floor(u)).astype(np.int64)
    return number, smoothstep(np.minimum(to_edge_u, to_edge_v), 0.5 * grout_texels, grout_texels + 0.7)


def floor_tiles(rng: np.random.Generator, size: int) -> Texture:
    """Stoneware, 1.2 m of it: 0.3 m tiles that differ in shade, with veins and grey joints."""
    number, tile = _tiles(rng, size, 4, 4, staggered=False, grout_texels=1.2)
    tone = rng.normal(0, 0.022, 16)[number]
    body = 0.78 + tone + 0.035 * fractal(rng, size, exponent=1.2) + 0.018 * fractal(rng, size, exponent=0.2)
    veins = 1 - smoothstep(np.abs(fractal(rng, size, exponent=1.6, highest=40)), 0.0, 0.1)
    colour = (
        blend((0.52, 0.50, 0.47), (1.0, 0.985, 0.96), tile)
        * np.where(tile > 0.5, body - 0.09 * veins, 0.9)[..., None]
    )
    return texture(colour, 1.2, height_m=tile * 1e-3)


def wall_tiles(rng: np.random.Generator, size: int) -> Texture:
    """Glazed metro tiles, 0.6 m of them: 0.15 x 0.075 m, staggered."""
    number, tile = _tiles(rng, size, 4, 8, staggered=True, grout_texels=1.4)
    tone = rng.normal(0, 0.018, 32)[number]
    glaze = 0.92 + tone + 0.012 * fractal(rng, size, exponent=1.5) + 0.006 * fractal(rng, size, exponent=0.2)
    return texture(blend((0.60, 0.59, 0.57), (1, 1, 1), tile) * glaze[..., None], 0.6, height_m=tile * 1.2e-3)


def mosaic(rng: np.random.Generator, size: int) -> Texture:
    """Glass mosaic, 0.4 m of it: 25 mm squares in related colours."""
    number, tile = _tiles(rng, size, 16, 16, staggered=False, grout_texels=1.2)
    key = np.array(muted(rng, saturation=(0.1, 0.5), value=(0.45, 0.85)))
    colours = np.clip(key + rng.normal(0, 0.09, (256, 1)) + rng.normal(0, 0.035, (256, 3)), 0.1, 0.97)
    grain = 1 + 0.02 * fractal(rng, size, exponent=0.8)
    return texture(
        blend((0.78, 0.78, 0.76), colours[number], tile) * grain[..., None], 0.4, height_m=tile * 8e-4
    )


def marble(rng: np.random.Generator, size: int) -> Texture:
    """Polished stone, 0.8 m of it: clouds and veins."""
    cloud = fractal(rng, size, exponent=1.6)
    veins = 1 - smoothstep(np.abs(fractal(rng, size, exponent=1.5, highest=60)), 0.0, 0.09)
    fine = 1 - smoothstep(np.abs(fractal(rng, size, exponent=1.1, lowest=4)), 0.0, 0.05)
    shade = 0.84 + 0.035 * cloud - 0.20 * veins - 0.07 * fine + 0.012 * fractal(rng, size, exponent=0.2)
    return texture(shade, 0.8)


def glaze(rng: np.random.Generator, size: int) -> Texture:
    """Sanitary ceramic, 0.6 m of it: nearly even, with faint water marks."""
    marks = smoothstep(fractal(rng, size, exponent=1.0, stretch=(1.0, 4.0), lowest=4), 1.4, 3.0)
    shade = 0.955 + 0.008 * fractal(rng, size, exponent=1.5) - 0.035 * marks
    return texture(shade, 0.6)


def brushed(rng: np.random.Generator, size: int) -> Texture:
    """Brushed metal, 0.3 m of it, with scratches along u and fingermarks."""
    lines = fractal(rng, size, exponent=0.2, stretch=(40.0, 1.0), lowest=10)
    marks = fractal(rng, size, exponent=1.6, highest=24)
    scratches = smoothstep(fractal(rng, size, exponent=0.5, stretch=(10.0, 1.0), lowest=8), 2.2, 3.4)
    shade = 0.83 + 0.05 * lines + 0.03 * marks - 0.18 * scratches
    return texture(shade, 0.3)


def moulded(rng: np.random.Generator, size: int) -> Texture:
    """Moulded plastic and lacquer, 0.4 m of it: fine grain, wear, small scratches."""
    grain = fractal(rng, size, exponent=0.1, lowest=20)
    wear = fractal(rng, size, exponent=1.6)
    scratches = smoothstep(fractal(rng, size, exponent=0.7, stretch=(6.0, 1.0), lowest=6), 2.5, 3.4)
    shade = 0.92 + 0.012 * grain + 0.016 * wear - 0.10 * scratches
    return texture(shade, 0.4)
