"""Printed and living things: paintings, book spines, screens, the view outside, leaves, soil."""

from __future__ import annotations

import numpy as np

from tacos_worlds.kit.colours import muted
from tacos_worlds.kit.textures.noise import fractal, smoothstep
from tacos_worlds.kit.textures.texture import Texture, blend, texels_near, texture

SPINES = 32
"""Book spines in a row of the texture of :func:`book_spines`."""
SPINE_M = 0.03
"""Width of one spine [m]."""


def landscape(rng: np.random.Generator, size: int) -> Texture:
    """A painted landscape, 1 m across: sky, hills, water, brush strokes."""
    row = np.arange(size)[:, None] / size
    column = np.arange(size)[None, :] / size
    dusk = rng.uniform(0, 1)
    colour = blend(
        np.array([0.93, 0.82, 0.62]) * (1 - 0.2 * dusk),
        np.array([0.45, 0.62, 0.80]) * (1 - 0.3 * dusk),
        np.broadcast_to(smoothstep(row, 0.35, 1.0), (size, size)),
    )
    clouds = smoothstep(fractal(rng, size, exponent=1.6, stretch=(2.5, 1.0)), 0.2, 1.6) * (row > 0.5)
    colour = blend(colour, (0.97, 0.94, 0.90), 0.7 * clouds)
    for depth in range(4):
        base = 0.62 - 0.15 * depth
        waves = sum(
            rng.normal(0, 0.05 / k) * np.sin(2 * np.pi * (k * column + rng.uniform())) for k in range(1, 6)
        )
        ink = (
            np.array([0.30, 0.42, 0.45]) * (1 - 0.2 * depth)
            + np.array([0.06, 0.05, -0.03]) * depth
            + rng.normal(0, 0.03, 3)
        )
        mottle, hill = 1 + 0.18 * fractal(rng, size, exponent=0.9), row < base + waves
        for channel in range(3):
            colour[hill, channel] = np.clip(ink[channel] * mottle[hill], 0, 1)
    strokes = fractal(rng, size, exponent=0.5, stretch=(5.0, 1.0), lowest=6)
    return texture(np.clip(colour * (1 + 0.05 * strokes[..., None]), 0, 1), 1.0)


def abstract(rng: np.random.Generator, size: int) -> Texture:
    """An abstract painting, 1 m across: fields, bars and discs of oil paint."""
    colour = np.broadcast_to(muted(rng, saturation=(0.02, 0.2), value=(0.75, 0.95)), (size, size, 3)).copy()
    row, column = np.indices((size, size)) / size
    for _ in range(14):
        ink = np.array(muted(rng, saturation=(0.2, 0.85), value=(0.15, 0.95)))
        (u, v), (w, h) = rng.uniform(0, 1, 2), rng.uniform(0.04, 0.3, 2)
        if rng.uniform() < 0.4:
            inside = np.hypot(column - u, row - v) < w
        else:
            turn = rng.choice([0.0, 0.0, rng.uniform(0, 3)])
            x, y = (
                (column - u) * np.cos(turn) + (row - v) * np.sin(turn),
                (row - v) * np.cos(turn) - (column - u) * np.sin(turn),
            )
            inside = (np.abs(x) < w) & (np.abs(y) < h)
        colour[inside] = colour[inside] * 0.12 + ink * 0.88
    strokes = fractal(rng, size, exponent=0.6, stretch=(1.0, 6.0), lowest=5)
    return texture(np.clip(colour * (1 + 0.06 * strokes[..., None]), 0, 1), 1.0)


def photograph(rng: np.random.Generator, size: int) -> Texture:
    """A black-and-white photograph of a street of houses, 1 m across."""
    column = np.arange(size) / size
    shade = np.broadcast_to((0.55 + 0.35 * np.arange(size) / size)[:, None], (size, size)).copy()
    left = 0.0
    while left < 1.0:
        width, height, tone = rng.uniform(0.08, 0.2), rng.uniform(0.3, 0.85), rng.uniform(0.15, 0.7)
        columns = (column >= left) & (column < left + width)
        rows = np.arange(size) < height * size
        shade[np.ix_(rows, columns)] = tone
        for sill in np.arange(0.1, height - 0.06, 0.11):
            for jamb in np.arange(left + 0.015, left + width - 0.03, 0.045):
                pane = np.ix_(
                    (np.arange(size) / size > sill) & (np.arange(size) / size < sill + 0.06),
                    (column > jamb) & (column < jamb + 0.026),
                )
                shade[pane] = rng.choice([0.06, 0.12, 0.9])
        left += width
    shade = shade * (1 + 0.05 * fractal(rng, size, exponent=0.6))
    margin = (
        np.minimum(np.minimum(column, 1 - column)[None, :], np.minimum(column, 1 - column)[:, None]) < 0.09
    )
    return texture(np.where(margin, 0.93, np.clip(shade, 0, 1)), 1.0)


def view_outside(rng: np.random.Generator, size: int) -> Texture:
    """View from a window at dusk, 2 m across: sky, trees, lit windows far away, all out of focus."""
    row = np.arange(size)[:, None] / size
    sky = blend(
        (0.62, 0.60, 0.60), (0.30, 0.37, 0.50), np.broadcast_to(smoothstep(row, 0.3, 1.0), (size, size))
    )
    sky = sky + 0.03 * fractal(rng, size, exponent=1.8, stretch=(2.0, 1.0))[..., None]
    trees = 0.42 + 0.07 * fractal(rng, size, exponent=1.3, highest=30)[0][None, :] - row
    colour = blend(
        sky,
        (0.10, 0.14, 0.11),
        smoothstep(trees + 0.02 * fractal(rng, size, exponent=1.0, highest=50), -0.01, 0.03),
    )
    lawn = np.broadcast_to(1 - smoothstep(row, 0.10, 0.16), (size, size))
    colour = blend(colour, (0.17, 0.21, 0.13), lawn)
    for _ in range(12):
        u, v = rng.uniform(0, 1), rng.uniform(0.18, 0.4)
        at = np.ix_(texels_near(v, 0.1, size), texels_near(u, 0.1, size))  # beyond, it changes no last bit
        du = (at[1] / size - u + 0.5) % 1 - 0.5
        glow = np.exp(-((du / 0.012) ** 2 + ((at[0] / size - v) / 0.014) ** 2))
        colour[at] = blend(colour[at], (0.95, 0.75, 0.42), 0.8 * glow)
    return texture(colour, 2.0)


def book_spines(rng: np.random.Generator, size: int) -> Texture:
    """A row of book spines along u, bands and lettering on each; see `SPINES` and `SPINE_M`."""
    colour = np.empty((size, size, 3))
    width = size // SPINES
    rows = np.arange(size) / size
    for book in range(SPINES):
        cover = np.array(muted(rng, saturation=(0.1, 0.8), value=(0.12, 0.9)))
        ink = np.clip(cover + (0.55 if cover.mean() < 0.45 else -0.5), 0.03, 0.97)
        column = np.broadcast_to(cover, (size, width, 3)).copy()
        for _ in range(rng.integers(1, 5)):
            at, thick = rng.uniform(0, 1), rng.uniform(0.004, 0.03)
            column[np.abs(rows - at) < thick] = ink
        letters = rng.uniform(0, 1, size // 4).repeat(4) < 0.55
        title = (np.abs(rows - rng.uniform(0.4, 0.6)) < rng.uniform(0.1, 0.22)) & letters[:size]
        middle = slice(width // 3, max(width // 3 + 1, 2 * width // 3))
        column[title, middle] = ink
        column *= np.interp(np.arange(width), [0, width * 0.2, width * 0.8, width - 1], [0.6, 1, 1, 0.6])[
            None, :, None
        ]
        colour[:, book * width : (book + 1) * width] = column
    return texture(colour * (0.95 + 0.04 * fractal(rng, size, exponent=0.8)[..., None]), SPINES * SPINE_M)


def desktop(rng: np.random.Generator, size: int) -> Texture:
    """A computer's screen, 0.6 m across: windows with text over a wallpaper."""
    colour = blend(
        muted(rng, value=(0.1, 0.3)),
        muted(rng, value=(0.3, 0.6)),
        smoothstep(fractal(rng, size, exponent=2.0), -1.5, 1.5),
    )
    for _ in range(3):
        left, low = rng.integers(4, size // 2, 2)
        right, high = left + rng.integers(size // 4, size // 2), low + rng.integers(size // 4, size // 2)
        paper, ink = (0.95, 0.15) if rng.uniform() < 0.6 else (0.12, 0.75)
        page = colour[low:high, left:right]
        page[:] = paper
        page[-5:] = muted(rng)
        for line in range(5, len(page) - 9, 5):
            words = np.repeat(rng.uniform(0, 1, page.shape[1] // 3 + 1) < 0.7, 3)[: page.shape[1]]
            words[int(page.shape[1] * rng.uniform(0.4, 0.95)) :] = False
            words[:4] = False
            page[line : line + 2, words] = ink
    return texture(colour, 0.6)


def foliage(rng: np.random.Generator, size: int) -> Texture:
    """Leaf surface, 0.2 m of it: veins off a midrib along u, blotches."""
    u = np.arange(size)[None, :] / size
    v = np.abs((np.arange(size)[:, None] / size * 2) % 1 - 0.5) * 2
    side = np.abs(np.sin(np.pi * (u * 12 - v * 4)))
    veins = 1 - smoothstep(side, 0.0, 0.18)
    shade = 0.72 + 0.08 * fractal(rng, size, exponent=1.2) + 0.05 * fractal(rng, size, exponent=0.3)
    colour = blend(np.array([0.55, 0.70, 0.42]), (0.78, 0.86, 0.60), 0.6 * veins) * shade[..., None] / 0.72
    return texture(np.clip(colour, 0, 1), 0.2)


def soil(rng: np.random.Generator, size: int) -> Texture:
    """Potting soil, 0.2 m of it."""
    clods = fractal(rng, size, exponent=0.4, lowest=6)
    bark = smoothstep(fractal(rng, size, exponent=0.5, stretch=(3.0, 1.0), lowest=8), 1.6, 2.2)
    return texture(
        blend(
            np.clip(0.24 + 0.07 * clods, 0.04, 1)[..., None] * np.array([1.0, 0.82, 0.66]),
            (0.55, 0.40, 0.27),
            bark,
        ),
        0.2,
    )


def wicker(rng: np.random.Generator, size: int) -> Texture:
    """Basket work, 0.2 m of it."""
    u, v = np.arange(size)[None, :] / size * 16, np.arange(size)[:, None] / size * 24
    strand = np.abs(np.sin(np.pi * v)) * (0.6 + 0.4 * np.abs(np.cos(np.pi * (u + np.floor(v) % 2) / 2)))
    shade = 0.35 + 0.55 * strand + 0.05 * fractal(rng, size, exponent=0.5, stretch=(6.0, 1.0))
    return texture(shade[..., None] * np.array([1.0, 0.84, 0.62]), 0.2, height_m=strand * 2e-3)
