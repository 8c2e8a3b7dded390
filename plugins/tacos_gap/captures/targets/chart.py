"""A ColorChecker under unknown light: what its patches would give in a linear camera with true colours."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.capture import RealCapture
from tacos_gap.captures.targets.chart_finder import FoundChart, read_as_chart
from tacos_gap.captures.targets.chart_pixels import filter_of
from tacos_gap.captures.targets.lattice import find_lattice
from tacos_worlds.bench.colour_chart import REFLECTANCES

NEUTRALS = slice(18, 24)
"""The patches from white to black."""

CLEARLY = 0.7
"""Misfit of a curve over that of a line with an offset below which the neutral patches are taken to lie on
the curve. Gloss and the chart's age (the reference is good to 2 %) bend a line by a little."""


CLEAR = 10.0
"""Code above the pedestal over its standard error from which on a patch is not black: its logarithm is good
to a tenth, however few codes of the scale a dim chart uses."""

_ROUNDING_DN = 0.1
"""What is left of the rounding of codes in the middle value of a patch that noise spreads over a few."""


@dataclass(frozen=True, eq=False)
class ChartLight:
    """Light and response by the neutral patches."""

    white_dn: NDArray[np.float64]
    slope: float
    """Of the logarithm of code against that of reflectance: 1 for a linear camera, about .45 for pictures
    made for a display."""
    offset_dn: NDArray[np.float64]
    """(3,) what a linear camera adds to every patch: a pedestal, or veiling light; 0 on a curve [DN]."""


@cache
def reference_colours() -> NDArray[np.float64]:
    """(24, 3) linear sRGB reflectances of the patches in order; those out of gamut at a thousandth."""
    return np.maximum(np.array(list(REFLECTANCES.values())), 1e-3)


def find_chart(rgb: NDArray[np.floating]) -> FoundChart | None:
    lattice = find_lattice(rgb)
    return None if lattice is None else read_as_chart(lattice, reference_colours())  # slow to import


def patch_colours(capture: RealCapture, boxes: NDArray[np.int64]) -> NDArray[np.float64]:
    """(P, 3) middle values of patches above the pedestal [DN]."""
    middle = [np.median(pixels, axis=1) for pixels in _pixels(capture, boxes)]
    return np.asarray(middle, np.float64) - capture.context.black_level_dn


def patch_errors(capture: RealCapture, boxes: NDArray[np.int64]) -> NDArray[np.float64]:
    """(P, 3) standard errors of these, the rounding of codes that noise does not spread included [DN]."""
    return np.array(
        [
            np.hypot(pixels.std(axis=1) / np.sqrt(pixels.shape[1]), _ROUNDING_DN)
            for pixels in _pixels(capture, boxes)
        ]
    )


def _pixels(capture: RealCapture, boxes: NDArray[np.int64]) -> Iterator[NDArray[np.float64]]:
    """(3, K) values of each patch, colour by colour [DN]."""
    mean = capture.real_dn.mean(axis=0)
    if mean.shape[-1] == 3:
        for x, y, w, h in boxes:
            yield mean[y : y + h, x : x + w].reshape(-1, 3).T.astype(np.float64)
        return
    filters = filter_of(capture)
    for x, y, w, h in boxes:
        values, own = (part[y : y + h, x : x + w].ravel() for part in (mean[..., 0], filters))
        colours = [values[own == number] for number in range(3)]
        fewest = min(len(colour) for colour in colours)
        yield np.array([colour[:fewest] for colour in colours], np.float64)


def light_on(
    capture: RealCapture, colours_dn: NDArray[np.float64], errors_dn: NDArray[np.float64]
) -> ChartLight | None:
    """Light and response by the neutral patches.

    A line with an offset per channel, or a power whose exponent the channels share: what fits clearly better.

    - `colours_dn`: (24, 3) what the patches gave above the pedestal [DN].
    - `errors_dn`: (24, 3) standard errors of these [DN].

    Returns None where fewer than four neutral patches are neither clipped nor black.
    """
    span = capture.context.white_level_dn - capture.context.black_level_dn
    code = colours_dn[NEUTRALS] / span
    reflectance = reference_colours()[NEUTRALS]
    usable = (colours_dn[NEUTRALS] > CLEAR * errors_dn[NEUTRALS]) & (code < 0.97)
    if min(usable.sum(axis=0)) < 4:
        return None
    channels = [(reflectance[use, c], code[use, c]) for c, use in enumerate(usable.T)]
    lines = [np.polyfit(x, y, 1, w=1 / y) for x, y in channels]
    misfit_of_line = _rms([np.polyval(line, x) / y - 1 for line, (x, y) in zip(lines, channels, strict=True)])
    slope, constants = _power(channels)
    misfit_of_power = _rms(
        [np.exp(c) * x**slope / y - 1 for c, (x, y) in zip(constants, channels, strict=True)]
    )
    if misfit_of_power < CLEARLY * misfit_of_line:
        return ChartLight(np.exp(np.array(constants) / slope) * span, slope, np.zeros(3))
    scale, offset = np.array(lines).T * span
    return ChartLight(scale, 1.0, offset)


def _power(channels: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]]) -> tuple[float, list[float]]:
    """Exponent and constants of code = exp(constant) reflectance^exponent, by logarithms."""
    logs = [(np.log(x), np.log(y)) for x, y in channels]
    dx = np.concatenate([x - x.mean() for x, _ in logs])
    dy = np.concatenate([y - y.mean() for _, y in logs])
    slope = float(dx @ dy / (dx @ dx))
    return slope, [float(y.mean() - slope * x.mean()) for x, y in logs]


def _rms(parts: Sequence[NDArray[np.float64]]) -> float:
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))


def expected_patches(
    capture: RealCapture, boxes: NDArray[np.int64], colours_dn: NDArray[np.float64]
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """(1, H, W, C) linear file values with patches of given colours [DN], and (H, W) where they are."""
    expected = np.full((1, *capture.real_dn.shape[1:]), capture.context.black_level_dn, np.float32)
    inside = np.zeros(capture.valid.shape, bool)
    filters = filter_of(capture) if expected.shape[-1] == 1 else None
    for (x, y, width, height), colour in zip(boxes.tolist(), colours_dn.astype(np.float32), strict=True):
        part = slice(y, y + height), slice(x, x + width)
        expected[(0, *part)] += colour if filters is None else colour[filters[part]][..., None]
        inside[part] = True
    return expected, inside
