"""Triangle and depth at each sample of an image, without OpenGL.

Where OpenGL is software, a pass that only says what is seen costs it mostly bookkeeping; here a row of a
triangle is one short loop. Coverage is exact on a grid of 1/256 of a sample, with the usual rule for samples
on shared edges, so that neighbours neither overlap nor leave gaps. Depth is interpolated as its inverse,
which is linear in the image (Blinn, "Hyperbolic interpolation", IEEE CG&A 1992).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.compiled.loops import compiled, inlined, unaliased
from tacos_plugins.renderers.software.covered import BLOCK, is_hidden, nothing_drawn
from tacos_plugins.renderers.software.lanes import LANES
from tacos_plugins.renderers.software.projected import (
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
    TRIANGLE,
    Projected,
    X,
    Y,
)

_ROUNDING = 2.0**-19  # between a depth found here and by OpenGL, of the depth of its window


def look(
    projected: Sequence[Projected],
    inverse_depth: NDArray[np.float32],
    seen: NDArray[np.int32],
    first_row: int,
) -> None:
    """Draw a band of rows of an image.

    `inverse_depth`, `seen`: (rows, W) are filled: inverse depth [1/m] and number of the triangle, 0 for
    nothing. `with_lanes` makes them, as loops take what lies behind their end along. `first_row`: row of the
    whole image that the first one here is.
    """
    inverse_depth.fill(0)
    seen.fill(0)
    lowest = nothing_drawn(seen.shape)
    for triangles in projected:
        draw(inverse_depth, seen, lowest, *triangles, first_row)


@compiled
def at_centres(
    inverse_depth: NDArray[np.float32],
    triangle: NDArray[np.int32],
    surface_of_triangle: NDArray[np.int32],
    depth_m: NDArray[np.float32],
    seen: NDArray[np.int32],
    surface: NDArray[np.float32],
) -> None:
    """View of pixel centres in an image of half pixels.

    - `inverse_depth`, `triangle`: (2 H + 1, 2 W + 1) as drawn [1/m, 1].
    - `surface_of_triangle`: (T + 1,) the surface that each triangle is of, 0 for no triangle.
    - `depth_m`, `seen`, `surface`: (H, W) are filled: depth, infinite for nothing [m]; triangle and surface,
      0 for nothing.
    """
    height, width = depth_m.shape
    for y in range(height):
        for x in range(width):
            depth_m[y, x] = np.float32(1) / inverse_depth[2 * y + 1, 2 * x + 1]
            number = triangle[2 * y + 1, 2 * x + 1]
            seen[y, x] = number
            surface[y, x] = surface_of_triangle[number]


@compiled
def farthest_behind(
    inverse_depth: NDArray[np.float32], window_of_inverse: tuple[float, float], behind: NDArray[np.float32]
) -> None:
    """A depth buffer that hides from OpenGL what no pixel sees.

    - `inverse_depth`: (2 H + 1, 2 W + 1) as drawn [1/m].
    - `window_of_inverse`: constant and slope that make a depth of OpenGL's window out of an inverse depth [1,
      m].
    - `behind`: (H, W) is filled: the window depth of the farthest place in each pixel, as OpenGL may round an
      edge to the other side of a centre [1].
    """
    constant, slope = np.float32(window_of_inverse[0] + _ROUNDING), np.float32(window_of_inverse[1])
    height, width = behind.shape
    lowest = np.empty(2 * width + 1, np.float32)
    for y in range(height):
        above, middle, below = inverse_depth[2 * y], inverse_depth[2 * y + 1], inverse_depth[2 * y + 2]
        for x in range(2 * width + 1):
            lowest[x] = min(min(above[x], middle[x]), below[x])
        for x in range(width):
            farthest = min(min(lowest[2 * x], lowest[2 * x + 1]), lowest[2 * x + 2])
            behind[y, x] = min(constant + slope * farthest, np.float32(1))


@compiled
def draw(
    inverse_depth: NDArray[np.float32],
    seen: NDArray[np.int32],
    lowest: NDArray[np.float32],
    places: NDArray[np.int64],
    levels: NDArray[np.float64],
    first_row: int,
) -> None:
    """Draw triangles over what is there; of equal depths the first counts.

    A band of rows drawn by itself is, bit by bit, that part of the whole image.

    - `inverse_depth`, `seen`: (H, W) what is drawn into, see `look`: inverse depth [1/m] and number of the
      triangle, 0 for nothing.
    - `lowest`: (H, blocks) at most the least inverse depth in each block of a row, by which what is hidden is
      passed over; 0 for nothing [1/m].
    - `places`, `levels`: the triangles on the whole image, as in `Projected`.
    - `first_row`: row of the whole image that the first one here is.
    """
    last_row, width = first_row + len(seen) - 1, seen.shape[1]
    depths, numbers = inverse_depth.reshape(-1), seen.reshape(-1)
    for triangle in range(len(places)):
        first = max(places[triangle, FIRST_ROW], first_row)
        last = min(places[triangle, LAST_ROW], last_row)
        if first <= last:
            least, most = places[triangle, FIRST_COLUMN], places[triangle, LAST_COLUMN]
            nearest = np.float32(levels[triangle, NEAREST])
            if not is_hidden(lowest, first - first_row, last - first_row, least, most, nearest):
                rows = (first, last, first_row)
                _fill(depths, numbers, lowest, width, places, levels, triangle, rows)


# Not inlined: of arrays handed to what it inlines numba counts references, each time, in locked instructions.
@compiled
def _fill(
    depths: NDArray[np.float32],
    numbers: NDArray[np.int32],
    lowest: NDArray[np.float32],
    width: int,
    places: NDArray[np.int64],
    levels: NDArray[np.float64],
    triangle: int,
    rows: tuple[int, int, int],
) -> None:
    """Draw one triangle between two rows of the whole image; the third row is the first drawn into."""
    begin_row, end_row, first_row = rows
    leftmost, rightmost = places[triangle, FIRST_COLUMN], places[triangle, LAST_COLUMN]
    along_x, along_y = levels[triangle, ALONG_X], levels[triangle, ALONG_Y]
    farthest, nearest = np.float32(levels[triangle, FARTHEST]), np.float32(levels[triangle, NEAREST])
    x0, y0, level0 = levels[triangle, X], levels[triangle, Y], levels[triangle, LEVEL]
    number = np.int32(places[triangle, TRIANGLE])
    corners = (
        places[triangle, 0],
        places[triangle, 1],
        places[triangle, 2],
        places[triangle, 3],
        places[triangle, 4],
        places[triangle, 5],
    )
    above = _middle(corners[1], corners[3], corners[5]) // SUB
    for part in range(2):
        begin = begin_row if part == 0 else max(begin_row, above + 1)
        end = min(end_row, above) if part == 0 else end_row
        if begin > end:
            continue
        low, low_rest, low_more, low_more_rest, low_divisor = _laid(corners, -1, part, begin)
        high, high_rest, high_more, high_more_rest, high_divisor = _laid(corners, 1, part, begin)
        for y in range(begin, end + 1):
            left, right = max(leftmost, -low), min(rightmost, high)
            if left <= right:
                level = level0 + along_x * (left - x0) + along_y * (y - y0)
                row = y - first_row
                if right - left < BLOCK:  # most of them
                    _fill_span(
                        depths, numbers, row * width + left, 0, right + 1 - left, number,
                        np.float32(level), np.float32(along_x), farthest, nearest,
                    )  # fmt: skip
                else:
                    _fill_blocks(
                        depths, numbers, lowest, row, width, left, right, number,
                        np.float32(level), np.float32(along_x), farthest, nearest,
                    )  # fmt: skip
            low, low_rest = low + low_more, low_rest + low_more_rest
            if low_rest >= low_divisor:
                low, low_rest = low + 1, low_rest - low_divisor
            high, high_rest = high + high_more, high_rest + high_more_rest
            if high_rest >= high_divisor:
                high, high_rest = high + 1, high_rest - high_divisor


@compiled
def _laid(
    corners: tuple[int, int, int, int, int, int], side: int, part: int, first: int
) -> tuple[int, int, int, int, int]:
    """Figures for the rows from `first` on of the edge on a side: -1 the left, 1 the right one.

    Samples within are those x that are at most floor(c / d), or at least its negative on the left. From row
    to row c changes by a constant, so quotient and remainder follow without a division: both, their changes,
    and the divisor.

    `part`: 0 for the edge from the upper corner, 1 for that to the lower one.
    """
    top, bottom = min(corners[1], corners[3], corners[5]), max(corners[1], corners[3], corners[5])
    for corner in range(3):
        following = 2 * ((corner + 1) % 3)
        ax, ay, bx, by = (
            corners[2 * corner],
            corners[2 * corner + 1],
            corners[following],
            corners[following + 1],
        )
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


@compiled
def _fill_blocks(
    depths: NDArray[np.float32],
    numbers: NDArray[np.int32],
    lowest: NDArray[np.float32],
    row: int,
    width: int,
    left: int,
    right: int,
    own: np.int32,
    level: np.float32,
    slope: np.float32,
    farthest: np.float32,
    nearest: np.float32,
) -> None:
    """Draw a span block by block, but for those that are hidden."""
    start = left
    for block in range(left // BLOCK, right // BLOCK + 1):
        end = min(BLOCK * (block + 1), right + 1)
        at_start = level + slope * np.float32(start - left)
        at_end = level + slope * np.float32(end - 1 - left)
        at_start = min(max(at_start, farthest), nearest)  # slivers have wild slopes
        at_end = min(max(at_end, farthest), nearest)
        if max(at_start, at_end) > lowest[row, block]:
            place, begin = row * width + left, start - left
            _fill_span(depths, numbers, place, begin, end - left, own, level, slope, farthest, nearest)
            if start == BLOCK * block and (end - start == BLOCK or end == width):
                lowest[row, block] = max(lowest[row, block], min(at_start, at_end))
        start = end


@unaliased
def _fill_span(
    depths: NDArray[np.float32],
    numbers: NDArray[np.int32],
    place: int,
    begin: int,
    end: int,
    own: np.int32,
    level: np.float32,
    slope: np.float32,
    farthest: np.float32,
    nearest: np.float32,
) -> None:
    """Draw samples `begin` to `end` of a span, `place` being its first, in whole lanes.

    Most spans are so short that a loop of their own length would be over before it becomes wide. Samples in a
    lane behind the end are written as they were.
    """
    for first in range(begin, end, LANES):
        start, count = np.float32(np.int32(first)), np.float32(np.int32(end - first))
        for lane in range(LANES):
            offset = np.float32(np.int32(lane))
            at = np.uint64(place + first) + np.uint64(lane)
            here = min(max(level + slope * (start + offset), farthest), nearest)
            before = depths[at]
            is_nearer = (here > before) & (offset < count)
            depths[at] = here if is_nearer else before
            numbers[at] = own if is_nearer else numbers[at]
