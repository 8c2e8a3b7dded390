"""Wood: sawn boards for furniture, planks and parquet for floors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_worlds.kit.textures.noise import fractal, smoothstep
from tacos_worlds.kit.textures.texture import Texture, blend, texture

_PALE = (0.93, 0.84, 0.70)
_DARK = (0.70, 0.54, 0.36)


def _figure(rng: np.random.Generator, size: int, *, rings: float) -> NDArray[np.float64]:
    """(size, size) darkness 0..1 of grain along u: growth rings, pores, and a few knots."""
    bend = fractal(rng, size, exponent=2.0, stretch=(6.0, 1.0), highest=12)
    v = np.arange(size)[:, None] / size
    phase = np.round(rings) * v + 0.45 * bend
    for _ in range(rng.integers(0, 3)):
        at = rng.uniform(0, 1, 2)
        du = (np.arange(size)[None, :] / size - at[0] + 0.5) % 1 - 0.5
        dv = (v - at[1] + 0.5) % 1 - 0.5
        phase = phase + 1.6 * np.exp(-((du / 0.05) ** 2 + (dv / 0.025) ** 2))
    across = phase % 1
    ring = across**2.2 * (1 - smoothstep(across, 0.93, 1.0))
    pores = smoothstep(fractal(rng, size, exponent=0.3, stretch=(18.0, 1.0), lowest=12), 0.7, 2.4)
    streaks = fractal(rng, size, exponent=1.0, stretch=(14.0, 1.0))
    return np.asarray(np.clip(0.35 + 0.32 * ring + 0.28 * pores + 0.10 * streaks, 0, 1))


def board(rng: np.random.Generator, size: int) -> Texture:
    """Planed wood, 0.8 m of it; pale, so that a material's base colour can stain it."""
    figure = _figure(rng, size, rings=float(rng.integers(7, 14)))
    return texture(blend(_PALE, _DARK, figure), 0.8, height_m=-figure * 2e-4)


def _laid(
    rng: np.random.Generator,
    size: int,
    board_of: NDArray[np.int64],
    edge_texels: NDArray[np.float64],
    along_u: NDArray[np.bool_],
    size_m: float,
) -> Texture:
    """Boards cut at random from one figured sheet and laid side by side."""
    figure = _figure(rng, size, rings=16)
    count = int(board_of.max()) + 1
    shift = rng.integers(0, size, (count, 2))
    shade = rng.normal(0, 0.055, count) + rng.choice([0, 0, 0.09], count)
    warm = rng.normal(0, 0.018, count)
    row, column = np.indices((size, size))
    column, row = (column + shift[board_of, 0]) % size, (row + shift[board_of, 1]) % size
    grain = figure[np.where(along_u, row, column), np.where(along_u, column, row)]
    wear = 0.04 * fractal(rng, size, exponent=1.4)
    scratches = smoothstep(fractal(rng, size, exponent=0.6, stretch=(9.0, 1.0), lowest=6), 2.2, 3.2)
    gap = 1 - smoothstep(edge_texels, 0.4, 1.8)
    colour = blend(_PALE, _DARK, np.clip(0.85 * grain + shade[board_of] + wear - 0.15 * scratches, 0, 1))
    for channel, warmer in enumerate((1.0, 0.0, -1.5)):
        colour[..., channel] *= 1 + warm[board_of] * warmer
        colour[..., channel] *= 1 - 0.45 * gap
    return texture(colour, size_m, height_m=-gap * 6e-4 - grain * 8e-5)


def planks(rng: np.random.Generator, size: int) -> Texture:
    """Floor boards along u, 2 m of them, staggered."""
    rows = int(rng.choice([12, 14, 16]))
    row_edges = np.rint(np.linspace(0, size, rows + 1)).astype(int)
    row_of = np.searchsorted(row_edges, np.arange(size), side="right") - 1
    across = np.minimum(np.arange(size) - row_edges[row_of], row_edges[row_of + 1] - 1 - np.arange(size))
    joint = rng.uniform(0, 1, rows)
    half = np.floor((np.arange(size)[None, :] / size - joint[row_of][:, None]) * 2) % 2
    along = ((np.arange(size)[None, :] / size - joint[row_of][:, None]) * 2) % 1 * size / 2
    edge = np.minimum(across[:, None] + 0.5, np.minimum(along, size / 2 - along))
    board_of = (row_of[:, None] * 2 + half).astype(np.int64)
    return _laid(rng, size, board_of, edge, np.ones((size, size), bool), 2.0)


def parquet(rng: np.random.Generator, size: int) -> Texture:
    """Basket-weave parquet: squares of four strips, turned alternately, 1.28 m of it."""
    squares, strips = 4, 4
    cell = size // squares
    row, column = np.indices((size, size))
    turned = ((row // cell + column // cell) % 2).astype(bool)
    lateral = np.where(turned, column, row) % cell
    lengthwise = np.where(turned, row, column) % cell
    strip = cell // strips
    board_of = ((row // cell) * squares + column // cell) * strips + lateral // strip
    across = np.minimum(lateral % strip, strip - 1 - lateral % strip)
    along = np.minimum(lengthwise, cell - 1 - lengthwise)
    return _laid(rng, size, board_of, np.minimum(across, along) + 0.5, ~turned, 1.28)
