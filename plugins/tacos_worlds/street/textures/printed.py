"""Printed, painted and grown surfaces: road signs, posters, number plates, leaves, bark, car paint."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_worlds.kit.textures.noise import fractal, smoothstep
from tacos_worlds.kit.textures.texture import Texture, blend, texture

Colour = tuple[float, float, float]
RED, BLUE, WHITE, BLACK = (0.75, 0.06, 0.09), (0.04, 0.22, 0.58), (0.93, 0.93, 0.92), (0.06, 0.06, 0.07)


def _face(size: int, colour: Colour) -> NDArray[np.float64]:
    return np.tile(np.array(colour), (size, size, 1)).astype(np.float64)


def _draw(image: NDArray[np.float64], paint: Callable[[NDArray[np.uint8]], object], colour: Colour) -> None:
    """Paint what `paint` sets in a mask; drawn top row first, like all pictures."""
    mask = np.zeros(image.shape[:2], np.uint8)
    paint(mask)
    weight = mask[..., None] / 255.0
    image[:] = image * (1 - weight) + np.array(colour) * weight


def _sign(image: NDArray[np.float64]) -> Texture:
    """A sign's face, 1 m across; texture rows run from the bottom up."""
    return texture(image[::-1], 1.0)


def _write(image: NDArray[np.float64], text: str, colour: Colour, scale: float) -> None:
    size = len(image)
    font, thick = cv2.FONT_HERSHEY_DUPLEX, max(2, round(size * scale / 90))
    (wide, high), _ = cv2.getTextSize(text, font, scale * size / 100, thick)
    at = ((size - wide) // 2, (size + high) // 2)
    _draw(
        image,
        lambda mask: cv2.putText(mask, text, at, font, scale * size / 100, 255, thick, cv2.LINE_AA),
        colour,
    )


def speed_limit(rng: np.random.Generator, size: int) -> Texture:
    image, middle = _face(size, RED), (size // 2, size // 2)
    _draw(image, lambda mask: cv2.circle(mask, middle, round(0.39 * size), 255, -1, cv2.LINE_AA), WHITE)
    _write(image, str(rng.choice(["30", "40", "50"])), BLACK, 1.7)
    return _sign(image)


def no_entry(rng: np.random.Generator, size: int) -> Texture:
    image = _face(size, RED)
    low, high = (round(0.18 * size), round(0.42 * size)), (round(0.82 * size), round(0.58 * size))
    _draw(image, lambda mask: cv2.rectangle(mask, low, high, 255, -1), WHITE)
    return _sign(image)


def stop(rng: np.random.Generator, size: int) -> Texture:
    """A stop sign; the plate itself has eight corners."""
    image = _face(size, RED)
    _write(image, "STOP", WHITE, 1.25)
    return _sign(image)


def crossing_ahead(rng: np.random.Generator, size: int) -> Texture:
    image = _face(size, BLUE)
    triangle = np.array([[0.5, 0.14], [0.9, 0.86], [0.1, 0.86]]) * size
    _draw(image, lambda mask: cv2.fillPoly(mask, [triangle.astype(np.int32)], 255, cv2.LINE_AA), WHITE)

    def person(mask: NDArray[np.uint8]) -> None:
        def at(x: float, y: float) -> tuple[int, int]:
            return round(x * size), round(y * size)

        thick = max(2, size // 22)
        cv2.circle(mask, at(0.5, 0.36), round(0.05 * size), 255, -1, cv2.LINE_AA)
        for start, end in (
            ((0.5, 0.42), (0.5, 0.60)),
            ((0.5, 0.60), (0.38, 0.80)),
            ((0.5, 0.60), (0.62, 0.80)),
            ((0.5, 0.46), (0.38, 0.58)),
            ((0.5, 0.46), (0.62, 0.57)),
        ):
            cv2.line(mask, at(*start), at(*end), 255, thick, cv2.LINE_AA)

    _draw(image, person, BLACK)
    return _sign(image)


def street_name(rng: np.random.Generator, size: int) -> Texture:
    names = ("MILL ST", "HIGH ST", "PARK RD", "CHURCH ST", "STATION RD", "BRIDGE ST")
    image = _face(size, BLUE)
    _write(image, str(rng.choice(names)), WHITE, 0.72)
    return _sign(image)


def number_plate(rng: np.random.Generator, size: int) -> Texture:
    letters = "".join(rng.choice(list("ABCDEFGHKLMNPRSTUVWX"), 3))
    image = _face(size, (0.92, 0.92, 0.88))
    _write(image, f"{letters} {rng.integers(100, 999)}", BLACK, 0.62)
    return _sign(image)


def _spot(rng: np.random.Generator, size: int) -> Callable[[NDArray[np.uint8]], object]:
    (x, y), (x1, y1) = rng.integers(0, size, (2, 2)).tolist()
    radius = int(rng.integers(size // 16, size // 4))
    if rng.uniform() < 0.5:
        return lambda mask: cv2.circle(mask, (x, y), radius, 255, -1, cv2.LINE_AA)
    return lambda mask: cv2.line(mask, (x, y), (x1, y1), 255, radius // 2, cv2.LINE_AA)


def poster(rng: np.random.Generator, size: int) -> Texture:
    red, green, blue = rng.uniform(0.3, 0.95, 3).tolist()
    image = _face(size, (red, green, blue))
    for _ in range(int(rng.integers(5, 10))):
        red, green, blue = rng.uniform(0.05, 0.95, 3).tolist()
        _draw(image, _spot(rng, size), (red, green, blue))
    word = str(rng.choice(["SALE", "LIVE", "NEW", "JAZZ", "OPERA", "CIRCUS", "FRESH", "TRAVEL"]))
    _write(image, word, WHITE if image.mean() < 0.55 else BLACK, 1.2)
    return _sign(image * (0.97 + 0.02 * fractal(rng, size, exponent=0.5)[..., None]))


def leaves(rng: np.random.Generator, size: int) -> Texture:
    """Foliage, 2.5 m of it: lit leaves over dark gaps, in clumps."""
    fine = fractal(rng, size, exponent=0.35, lowest=10)
    clumps = fractal(rng, size, exponent=0.9, lowest=3, highest=30)
    light = np.clip(0.46 + 0.26 * fine + 0.16 * clumps, 0, 1)
    colour = blend((0.07, 0.12, 0.05), (0.47, 0.60, 0.25), light)
    yellow = smoothstep(fractal(rng, size, exponent=0.6, lowest=8), 1.6, 2.4)
    return texture(blend(colour, (0.62, 0.64, 0.30), 0.6 * yellow), 2.5, height_m=0.05 * fine)


def bark(rng: np.random.Generator, size: int) -> Texture:
    """Bark, 1.5 m of it, grooved along v."""
    groove = fractal(rng, size, exponent=0.5, stretch=(0.4, 1.6), lowest=4)
    shade = 0.36 + 0.09 * groove + 0.03 * fractal(rng, size, exponent=0.1)
    return texture(shade[..., None] * np.array([1.0, 0.88, 0.74]), 1.5, height_m=0.01 * groove)


def metal(rng: np.random.Generator, size: int) -> Texture:
    """Painted or galvanised metal, 1 m of it: spangle, scratches, runs of rust."""
    spangle = fractal(rng, size, exponent=0.4, highest=40)
    rust = smoothstep(fractal(rng, size, exponent=1.0, stretch=(0.3, 1.5)), 2.0, 3.2)
    shade = 0.88 + 0.03 * spangle + 0.02 * fractal(rng, size, exponent=0.0)
    return texture(blend(np.repeat(shade[..., None], 3, axis=2), (0.55, 0.36, 0.24), 0.6 * rust), 1.0)


def car_paint(rng: np.random.Generator, size: int) -> Texture:
    """Car paint, 2 m of it: even but for dust and dirt."""
    dust = smoothstep(fractal(rng, size, exponent=1.1), 0.6, 2.6)
    shade = 0.97 + 0.012 * fractal(rng, size, exponent=0.2)
    return texture(blend(np.repeat(shade[..., None], 3, axis=2), (0.72, 0.68, 0.62), 0.25 * dust), 2.0)
