"""Which surface is seen at each sample of an image, and how far away, without OpenGL.

Where OpenGL is software, a pass that only says what is seen costs it mostly bookkeeping; here a row of a
triangle is one short loop. Coverage is exact on a grid of 1/256 of a sample, with the usual rule for samples
on shared edges, so that neighbours neither overlap nor leave gaps. Depth is interpolated as its inverse,
which is linear in the image (Blinn, "Hyperbolic interpolation", IEEE CG&A 1992).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tacos_framework.compiled import compiled, inlined
from tacos_plugins.renderers.moderngl.covered import BLOCK, is_hidden, nothing_drawn
from tacos_plugins.renderers.moderngl.projected import (
    ALONG_X,
    ALONG_Y,
    FARTHEST,
    FIRST_COLUMN,
    FIRST_ROW,
    LAST_COLUMN,
    LAST_ROW,
    LEVEL,
    NEAREST,
    SUB,
    SURFACE,
    Projected,
    X,
    Y,
)

_ROUNDING = 2.0**-19  # between a depth found here and by OpenGL, of the depth of its window


def look(
    projected: Sequence[Projected],
    inverse_depth: NDArray[np.float32],
    surface: NDArray[np.int32],
    first_row: int,
) -> None:
    """Draw a band of rows of an image.

    Parameters
    ----------
    projected
        Triangles on the whole image.
    inverse_depth, surface
        (rows, W) are filled: inverse depth [1/m] and surface number, 0 for nothing.
    first_row
        Row of the whole image that the first one here is.
    """
    inverse_depth.fill(0)
    surface.fill(0)
    lowest = nothing_drawn(surface.shape)
    for triangles in projected:
        draw(inverse_depth, surface, lowest, triangles, first_row)


@compiled
def at_centres(
    inverse_depth: NDArray[np.float32],
    surface: NDArray[np.int32],
    window_of_inverse: tuple[float, float],
    depth_m: NDArray[np.float32],
    seen: NDArray[np.float32],
    behind: NDArray[np.float32],
) -> None:
    """What pixel centres see in an image of half pixels, and a depth buffer that hides what none sees.

    Parameters
    ----------
    inverse_depth, surface
        (2 H + 1, 2 W + 1) as drawn [1/m, 1].
    window_of_inverse
        Constant and slope that make a depth of OpenGL's window out of an inverse depth [1, m].
    depth_m, seen
        (H, W) are filled: depth, infinite for nothing, and surface, 0 for nothing [m, 1].
    behind
        (H, W) is filled: the window depth of the farthest place in each pixel, as OpenGL may round an edge to
        the other side of a centre [1].
    """
    constant, slope = np.float32(window_of_inverse[0] + _ROUNDING), np.float32(window_of_inverse[1])
    height, width = depth_m.shape
    lowest = np.empty(2 * width + 1, np.float32)
    for y in range(height):
        above, middle, below = inverse_depth[2 * y], inverse_depth[2 * y + 1], inverse_depth[2 * y + 2]
        for x in range(2 * width + 1):
            lowest[x] = min(min(above[x], middle[x]), below[x])
        numbers = surface[2 * y + 1]
        for x in range(width):
            depth_m[y, x] = np.float32(1) / middle[2 * x + 1]
            seen[y, x] = numbers[2 * x + 1]
            farthest = min(min(lowest[2 * x], lowest[2 * x + 1]), lowest[2 * x + 2])
            behind[y, x] = min(constant + slope * farthest, np.float32(1))


@compiled
def draw(
    inverse_depth: NDArray[np.float32],
    surface: NDArray[np.int32],
    lowest: NDArray[np.float32],
    projected: Projected,
    first_row: int,
) -> None:
    """Draw triangles over what is there; of equal depths the first counts.

    A band of rows drawn by itself is, bit by bit, that part of the whole image.

    Parameters
    ----------
    inverse_depth, surface
        (H, W) what is drawn into: 0 for nothing [1/m, 1].
    lowest
        (H, blocks) at most the least inverse depth in each block of a row, by which what is hidden is passed
        over; 0 for nothing [1/m].
    projected
        The triangles on the whole image.
    first_row
        Row of the whole image that the first one here is.
    """
    places, levels = projected
    last_row = first_row + len(surface) - 1
    for triangle in range(len(places)):
        first = max(places[triangle, FIRST_ROW], first_row)
        last = min(places[triangle, LAST_ROW], last_row)
        if first <= last:
            least, most = places[triangle, FIRST_COLUMN], places[triangle, LAST_COLUMN]
            nearest = np.float32(levels[triangle, NEAREST])
            if not is_hidden(lowest, first - first_row, last - first_row, least, most, nearest):
                rows = (first, last, first_row)
                _fill(inverse_depth, surface, lowest, places[triangle], levels[triangle], rows)


@compiled
def _fill(
    inverse_depth: NDArray[np.float32],
    surface: NDArray[np.int32],
    lowest: NDArray[np.float32],
    places: NDArray[np.int64],
    levels: NDArray[np.float64],
    rows: tuple[int, int, int],
) -> None:
    """Draw one triangle between two rows of the whole image; the third row is the first that is drawn into.

    Above its middle corner a row lies between two edges, and below it between two.
    """
    first, last, first_row = rows
    least, most = places[FIRST_COLUMN], places[LAST_COLUMN]
    along_x, along_y = levels[ALONG_X], levels[ALONG_Y]
    farthest, nearest = np.float32(levels[FARTHEST]), np.float32(levels[NEAREST])
    above = _middle(places[1], places[3], places[5]) // SUB
    for part in range(2):
        begin = first if part == 0 else max(first, above + 1)
        end = min(last, above) if part == 0 else last
        if begin > end:
            continue
        low, low_rest, low_more, low_more_rest, low_divisor = _laid(places, -1, part, begin)
        high, high_rest, high_more, high_more_rest, high_divisor = _laid(places, 1, part, begin)
        for y in range(begin, end + 1):
            left, right = max(least, -low), min(most, high)
            if left <= right:
                level = levels[LEVEL] + along_x * (left - levels[X]) + along_y * (y - levels[Y])
                row = y - first_row
                _fill_row(
                    inverse_depth[row], surface[row], lowest[row], left, right, places[SURFACE],
                    np.float32(level), np.float32(along_x), farthest, nearest,
                )  # fmt: skip
            low, low_rest = low + low_more, low_rest + low_more_rest
            if low_rest >= low_divisor:
                low, low_rest = low + 1, low_rest - low_divisor
            high, high_rest = high + high_more, high_rest + high_more_rest
            if high_rest >= high_divisor:
                high, high_rest = high + 1, high_rest - high_divisor


@compiled
def _laid(places: NDArray[np.int64], side: int, part: int, first: int) -> tuple[int, int, int, int, int]:
    """What the rows from `first` on need of the edge on a side: -1 the left, 1 the right one.

    Samples within are those x that are at most floor(c / d), or at least its negative on the left. From row
    to row c changes by a constant, so quotient and remainder follow without a division: both, their changes,
    and the divisor.

    Parameters
    ----------
    part
        0 for the edge from the upper corner, 1 for that to the lower one.
    """
    top, bottom = min(places[1], places[3], places[5]), max(places[1], places[3], places[5])
    for corner in range(3):
        following = 2 * ((corner + 1) % 3)
        ax, ay, bx, by = places[2 * corner], places[2 * corner + 1], places[following], places[following + 1]
        reaches = max(ay, by) == bottom if part else min(ay, by) == top
        if np.sign(by - ay) == side and reaches:
            break
    dx, dy = bx - ax, by - ay
    # Samples on left edges belong to the triangle, those on right ones to the next.
    c, divisor = dx * (SUB * first - ay) + dy * ax - (0 if side < 0 else 1), SUB * abs(dy)
    return c // divisor, c % divisor, (SUB * dx) // divisor, (SUB * dx) % divisor, divisor


@inlined
def _middle(a: int, b: int, c: int) -> int:
    return max(min(a, b), min(max(a, b), c))


@inlined
def _fill_row(
    inverse_depth: NDArray[np.float32],
    surface: NDArray[np.int32],
    lowest: NDArray[np.float32],
    left: int,
    right: int,
    number: int,
    level: np.float32,
    slope: np.float32,
    farthest: np.float32,
    nearest: np.float32,
) -> None:
    """Draw a span of a row, block by block: `level` is the inverse depth at its left end [1/m]."""
    own, start = np.int32(number), left
    for block in range(left // BLOCK, right // BLOCK + 1):
        end = min(BLOCK * (block + 1), right + 1)
        at_start = level + slope * np.float32(start - left)
        at_end = level + slope * np.float32(end - 1 - left)
        at_start = min(max(at_start, farthest), nearest)  # slivers have wild slopes
        at_end = min(max(at_end, farthest), nearest)
        if max(at_start, at_end) > lowest[block]:
            depths, numbers = inverse_depth[start:end], surface[start:end]
            for x in range(len(depths)):
                # Of a narrow number, which is made a float eight at a time.
                here = level + slope * np.float32(np.int32(start - left + x))
                here = min(max(here, farthest), nearest)
                before = depths[x]
                is_nearer = here > before
                depths[x] = here if is_nearer else before
                numbers[x] = own if is_nearer else numbers[x]
            if start == BLOCK * block and (end - start == BLOCK or end == len(surface)):
                lowest[block] = max(lowest[block], min(at_start, at_end))
        start = end
