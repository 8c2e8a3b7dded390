"""Fronts of buildings: four bays by four floors of a wall with its windows, shops, doors.

Ground floors are one floor high and fill the tile's height.
"""

from __future__ import annotations

import cv2
import numpy as np

from tacos_worlds.kit.textures.texture import Texture, texture
from tacos_worlds.street.textures.walls import CELL_M, CELLS, WALLS, Canvas, Colour, Image, ashlar, concrete
from tacos_worlds.street.textures.windows import WindowStyle, draw_window_style, glass, window


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
