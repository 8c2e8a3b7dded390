"""Walls of buildings with their windows: four bays by four floors of a front, drawn cell by cell.

A cell is one bay by one floor. Fronts are scaled so that whole cells fit the building, and all their texture
coordinates count cells, not metres; the metres below hold for a cell of `CELL_M`.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_plugins.scenes.indoor.textures.noise import fractal, smoothstep
from tacos_plugins.scenes.indoor.textures.texture import Texture, texture

CELLS = 4
"""Bays and floors of a tile."""
CELL_M = 3.2
"""Edge of a cell, about [m]."""

Image = NDArray[np.float64]
Colour = tuple[float, float, float]


@dataclass
class Canvas:
    """A wall being drawn, rows from the bottom up.

    Parameters
    ----------
    colour
        (T, T, 3) sRGB in 0..1.
    height_m
        (T, T) relief [m].
    """

    colour: Image
    height_m: Image

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
    """Bricks in running bond."""
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
    """Dressed stone in courses."""
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


@dataclass(frozen=True)
class WindowStyle:
    """How the windows of a front look; lengths in cells.

    Parameters
    ----------
    width, height, sill
        Of the opening, and its height above the floor.
    columns, rows
        Panes.
    trim
        Width of the surround; 0 for none.
    frame
        Colour of the frames.
    """

    width: float
    height: float
    sill: float
    columns: int
    rows: int
    trim: float
    frame: Colour


def draw_window_style(rng: np.random.Generator, wall: str) -> WindowStyle:
    """Windows that suit a wall."""
    wide = wall == "concrete"
    return WindowStyle(
        width=float(rng.uniform(0.6, 0.86) if wide else rng.uniform(0.32, 0.46)),
        height=float(rng.uniform(0.45, 0.56)),
        sill=float(rng.uniform(0.26, 0.32)),
        columns=int(rng.integers(2, 5)) if wide else 2,
        rows=int(rng.integers(1, 4)),
        trim=0.0 if wide else float(rng.choice([0.0, 0.035, 0.05])),
        frame=((0.93, 0.93, 0.91), (0.9, 0.9, 0.9), (0.25, 0.26, 0.28), (0.36, 0.27, 0.2))[
            int(rng.integers(4))
        ],
    )


def glass(rng: np.random.Generator, canvas: Canvas, u: tuple[float, float], v: tuple[float, float]) -> None:
    """Panes that mirror some sky, with what hangs or stands behind them."""
    rows, columns = canvas.rectangle(u, v)
    height, width = rows.stop - rows.start, columns.stop - columns.start
    sky = rng.uniform(0.05, 0.38) * np.linspace(0, 1, height)[:, None, None] * np.array([0.75, 0.9, 1.0])
    pane = np.broadcast_to(np.array([0.16, 0.19, 0.22]) + sky, (height, width, 3)).copy()
    kind = rng.uniform()
    if kind < 0.3:  # curtains to both sides
        cloth = np.array([0.86, 0.83, 0.76]) * rng.uniform(0.55, 0.95)
        folds = 1 + 0.12 * np.sin(np.arange(width) / max(width, 1) * rng.uniform(40, 70))[None, :, None]
        share = int(width * rng.uniform(0.15, 0.38))
        for side in (slice(0, share), slice(width - share, width)):
            pane[:, side] = cloth * np.broadcast_to(folds, pane.shape)[:, side]
    elif kind < 0.5:  # a blind
        drop = int(height * rng.uniform(0.2, 0.8))
        slats = 1 + 0.1 * np.sin(np.arange(height) * 1.6)[:, None, None]
        pane[height - drop :] = (np.array([0.85, 0.84, 0.8]) * rng.uniform(0.6, 0.95) * slats)[
            height - drop :
        ]
    elif kind < 0.6:  # a lamp is on
        pane[:] = 0.5 * pane + 0.5 * np.array([0.8, 0.68, 0.45])
    canvas.colour[rows, columns] = pane
    canvas.height_m[rows, columns] = -0.12


def window(
    rng: np.random.Generator, canvas: Canvas, style: WindowStyle, bay: int, floor: int, *, tall: bool = False
) -> None:
    """One window in its cell."""
    middle = bay + 0.5
    u = (middle - style.width / 2, middle + style.width / 2)
    v = (floor + (0.06 if tall else style.sill), floor + style.sill + style.height)
    if style.trim:
        t = style.trim
        canvas.fill((u[0] - t, u[1] + t), (v[0] - t, v[1] + t), (0.90, 0.88, 0.83), 0.03)
        canvas.shade((u[0] - t, u[1] + t), (v[0] - t - 0.012, v[0] - t), 0.6)
    frame = 0.022
    canvas.fill(u, v, style.frame, -0.08)
    step_u = (u[1] - u[0] - frame) / style.columns
    step_v = (v[1] - v[0] - frame) / style.rows
    for column in range(style.columns):
        for row in range(style.rows):
            left, low = u[0] + frame + column * step_u, v[0] + frame + row * step_v
            glass(rng, canvas, (left, left + step_u - frame), (low, low + step_v - frame))
    canvas.shade(u, (v[1] - 0.035, v[1]), 0.45)  # the lintel's shadow
    canvas.fill((u[0] - 0.03, u[1] + 0.03), (v[0] - 0.03, v[0]), (0.78, 0.77, 0.74), 0.06)
    canvas.shade((u[0] - 0.02, u[1] + 0.02), (v[0] - 0.05, v[0] - 0.03), 0.55)


def _finished(canvas: Canvas) -> Texture:
    return texture(canvas.colour, float(CELLS), height_m=canvas.height_m / CELL_M)


def front(rng: np.random.Generator, size: int, *, wall: str, tint: Colour) -> Texture:
    """Upper floors of a front: a window in each cell, no two alike."""
    canvas = WALLS[wall](rng, size)
    canvas.colour = canvas.colour * np.array(tint)
    style = draw_window_style(rng, wall)
    courses = wall != "concrete" and rng.uniform() < 0.5
    for floor in range(CELLS):
        if courses:
            canvas.fill((0, CELLS), (floor, floor + 0.05), (0.84, 0.82, 0.77), 0.04)
            canvas.shade((0, CELLS), (floor + 1 - 0.015, floor + 1), 0.7)
        for bay in range(CELLS):
            window(rng, canvas, style, bay, floor)
    return _finished(canvas)


def office(rng: np.random.Generator, size: int) -> Texture:
    """A curtain wall: bands of glass between spandrels."""
    canvas = concrete(rng, size)
    spandrel = np.array([(0.42, 0.47, 0.5), (0.6, 0.6, 0.58), (0.3, 0.36, 0.42)][int(rng.integers(3))])
    canvas.colour *= spandrel / 0.74
    for floor in range(CELLS):
        for bay in range(2 * CELLS):
            glass(rng, canvas, (bay / 2 + 0.02, bay / 2 + 0.48), (floor + 0.28, floor + 0.96))
            canvas.shade((bay / 2 + 0.02, bay / 2 + 0.48), (floor + 0.93, floor + 0.96), 0.6)
    return _finished(canvas)


def blank(rng: np.random.Generator, size: int, *, wall: str, tint: Colour) -> Texture:
    """A wall to a neighbour or a yard, with the odd small window."""
    canvas = WALLS[wall](rng, size)
    canvas.colour = canvas.colour * np.array(tint) * 0.94
    style = WindowStyle(0.26, 0.34, 0.42, 1, 2, 0.0, (0.85, 0.85, 0.83))
    for floor in range(CELLS):
        for bay in range(CELLS):
            if rng.uniform() < 0.3:
                window(rng, canvas, style, bay, floor)
    return _finished(canvas)


SHOPS = (
    "CAFE",
    "BAKERY",
    "BOOKS",
    "PHARMACY",
    "HOTEL",
    "MARKET",
    "BANK",
    "FLOWERS",
    "SHOES",
    "OPTICIAN",
    "TOYS",
    "TEA",
)
SIGN_COLOURS: tuple[Colour, ...] = (
    (0.10, 0.28, 0.18),
    (0.55, 0.10, 0.10),
    (0.10, 0.18, 0.42),
    (0.14, 0.14, 0.15),
    (0.80, 0.62, 0.18),
    (0.86, 0.85, 0.80),
)


def lettering(text: str, width: int, height: int) -> Image:
    """(height, width) 0..1 coverage of a word, rows from the bottom up."""
    mask = np.zeros((height, width), np.uint8)
    scale = 1.0
    (wide, high), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_DUPLEX, scale, 2)
    scale = min(0.86 * width / wide, 0.62 * height / high)
    (wide, high), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_DUPLEX, scale, 2)
    at = ((width - wide) // 2, (height + high) // 2)
    cv2.putText(mask, text, at, cv2.FONT_HERSHEY_DUPLEX, scale, 255, max(1, round(2 * scale)), cv2.LINE_AA)
    return mask[::-1] / 255.0


def shops(rng: np.random.Generator, size: int) -> Texture:
    """A ground floor of two shops, four bays wide; one floor fills the tile's height."""
    canvas = ashlar(rng, size)
    canvas.colour *= rng.uniform(0.5, 0.9)
    words = rng.choice(len(SHOPS), 2, replace=False)
    for shop in range(2):
        left = 2.0 * shop
        board = SIGN_COLOURS[int(rng.integers(len(SIGN_COLOURS)))]
        ink = (0.95, 0.93, 0.85) if sum(board) < 1.6 else (0.12, 0.12, 0.14)
        canvas.fill((left + 0.06, left + 1.94), (0.25, 3.95), _darker(board, 0.8), 0.02)
        for u in ((left + 0.12, left + 0.82), (left + 1.2, left + 1.88)):
            glass(rng, canvas, u, (0.55, 2.85))
            _display(rng, canvas, u, (0.55, 1.9))
            canvas.shade(u, (2.7, 2.85), 0.5)
        canvas.fill((left + 0.86, left + 1.16), (0.05, 2.7), _darker(board, 0.6), -0.1)
        glass(rng, canvas, (left + 0.9, left + 1.12), (0.9, 2.5))
        canvas.fill((left + 0.06, left + 1.94), (3.05, 3.75), board, 0.08)
        rows, columns = canvas.rectangle((left + 0.06, left + 1.94), (3.05, 3.75))
        mask = lettering(SHOPS[words[shop]], columns.stop - columns.start, rows.stop - rows.start)[..., None]
        canvas.colour[rows, columns] = canvas.colour[rows, columns] * (1 - mask) + mask * np.array(ink)
        canvas.shade((left + 0.06, left + 1.94), (2.95, 3.05), 0.5)
    canvas.shade((0, CELLS), (0, 0.2), 0.6)
    return _finished(canvas)


def _darker(colour: Colour, factor: float) -> Colour:
    red, green, blue = colour
    return factor * red, factor * green, factor * blue


def _display(
    rng: np.random.Generator, canvas: Canvas, u: tuple[float, float], v: tuple[float, float]
) -> None:
    """Goods in a shop window."""
    for _ in range(int(rng.integers(7, 14))):
        width, height = rng.uniform(0.04, 0.14), rng.uniform(0.12, 0.6)
        left, low = rng.uniform(u[0], u[1] - width), rng.uniform(v[0], v[1] - height)
        tone = 0.35 + 0.45 * rng.uniform() + rng.normal(0, 0.09, 3)
        red, green, blue = np.clip(tone, 0.08, 0.9).tolist()
        canvas.fill((left, left + width), (low, low + height), (red, green, blue), -0.14)


def entrance(rng: np.random.Generator, size: int, *, wall: str, tint: Colour) -> Texture:
    """A ground floor with windows and one door in four bays; one floor fills the tile's height."""
    upper = WALLS[wall](rng, size)
    canvas = Canvas(upper.colour * np.array(tint) * 0.9, upper.height_m)
    door = int(rng.integers(CELLS))
    for bay in range(CELLS):
        if bay == door:
            paint = SIGN_COLOURS[int(rng.integers(4))]
            canvas.fill((bay + 0.26, bay + 0.74), (0.0, 3.2), (0.86, 0.84, 0.79), 0.05)
            canvas.fill((bay + 0.32, bay + 0.68), (0.0, 2.5), paint, -0.1)
            for low in (0.3, 1.4):
                for left in (0.36, 0.52):
                    canvas.shade((bay + left, bay + left + 0.12), (low, low + 0.85), 0.7)
            glass(rng, canvas, (bay + 0.32, bay + 0.68), (2.56, 3.0))
        else:
            canvas.fill((bay + 0.24, bay + 0.76), (1.1, 3.3), (0.88, 0.86, 0.81), 0.03)
            for left in (0.29, 0.515):
                for low in (1.2, 2.25):
                    glass(rng, canvas, (bay + left, bay + left + 0.2), (low, low + 0.95))
            canvas.shade((bay + 0.24, bay + 0.76), (3.08, 3.2), 0.5)
    canvas.shade((0, CELLS), (0.0, 0.42), 0.62)  # splashes and dirt
    return _finished(canvas)
