"""Which surface is seen at each sample of an image, and how far away, without OpenGL.

Where OpenGL is software, a pass that only says what is seen costs it mostly bookkeeping; here a row of a
triangle is one short loop. Coverage is exact on a grid of 1/256 of a sample, with the usual rule for samples
on shared edges, so that neighbours neither overlap nor leave gaps. Depth is interpolated as its inverse,
which is linear in the image (Blinn, "Hyperbolic interpolation", IEEE CG&A 1992).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_framework.compiled import compiled, inlined
from tacos_framework.values import Camera
from tacos_plugins.renderers.moderngl.clipping import CORNERS, cut, needs_cutting
from tacos_plugins.renderers.moderngl.covered import BLOCK, along, box_is_hidden, is_hidden

_SUB = 256  # places a sample's width is divided into
_QUOTIENT, _REST, _MORE, _MORE_REST, _DIVISOR, _SIDE = range(6)  # what is kept of an edge from row to row
_ROUNDING = 2.0**-19  # between a depth found here and by OpenGL, of the depth of its window


def pixel_from_camera(camera: Camera) -> NDArray[np.float64]:
    """(3, 3) from camera coordinates [m] to homogeneous pixels, their centres integers; last is depth [m]."""
    (cx, cy), focal = camera.centre_px, camera.focal_length_px
    return np.array([[focal, 0.0, cx], [0.0, focal, cy], [0.0, 0.0, 1.0]])


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
    position_m: NDArray[np.float32],
    triangles: NDArray[np.int32],
    surface_of_vertex: NDArray[np.int32],
    runs: NDArray[np.int64],
    boxes_m: NDArray[np.float64],
    pixel_from_world: NDArray[np.float64],
    first_row: int,
    near_m: float,
    closed: bool,
) -> None:
    """Draw runs of triangles over what is there; of equal depths the first counts.

    A band of rows drawn by itself is, bit by bit, that part of the whole image.

    Parameters
    ----------
    inverse_depth, surface
        (H, W) what is drawn into: 0 for nothing [1/m, 1].
    lowest
        (H, blocks) at most the least inverse depth in each block of a row, by which what is hidden is passed
        over; 0 for nothing [1/m].
    position_m, surface_of_vertex
        (V, 3) and (V,) places of vertices and the surfaces they belong to [m, 1].
    triangles
        (T, 3) vertices of each triangle.
    runs
        (R, 2) first triangle and number of triangles of each run.
    boxes_m
        (R, 2, 3) lower and upper corners of boxes that hold them [m].
    pixel_from_world
        (3, 4) see `pixel_from_camera`.
    first_row
        Row of the whole image that the first one here is.
    near_m
        What is nearer is cut off [m].
    closed
        Whether backs are never seen, and need not be drawn.
    """
    corners = np.empty((CORNERS, 3))
    spare = np.empty((CORNERS, 3))
    edges = np.empty((3, 6), np.int64)
    height, width = surface.shape
    for run in range(len(runs)):
        if box_is_hidden(lowest, boxes_m[run], pixel_from_world, first_row, width, near_m):
            continue
        for triangle in range(runs[run, 0], runs[run, 0] + runs[run, 1]):
            for corner in range(3):
                vertex = triangles[triangle, corner]
                x, y, z = position_m[vertex, 0], position_m[vertex, 1], position_m[vertex, 2]
                for axis in range(3):
                    corners[corner, axis] = along(pixel_from_world[axis], x, y, z)
            if _beyond(corners, width, first_row, first_row + height - 1):
                continue
            count = 3
            if needs_cutting(corners, near_m):
                count = cut(corners, spare, near_m)
            for corner in range(count):
                inverse = 1 / corners[corner, 2]
                corners[corner, 0] *= inverse
                corners[corner, 1] *= inverse
                corners[corner, 2] = inverse
            number = surface_of_vertex[triangles[triangle, 0]]
            for corner in range(2, count):
                for axis in range(3):
                    spare[0, axis] = corners[0, axis]
                    spare[1, axis] = corners[corner - 1, axis]
                    spare[2, axis] = corners[corner, axis]
                _fill(inverse_depth, surface, lowest, spare, first_row, number, closed, edges)


@compiled
def _beyond(corners: NDArray[np.float64], width: int, first_row: int, last_row: int) -> bool:
    """Whether a triangle of homogeneous pixels lies beyond one side of some rows, and so shows nowhere."""
    left, right, over, under = True, True, True, True
    for corner in range(3):
        x, y, w = corners[corner, 0], corners[corner, 1], corners[corner, 2]
        left &= x < 0
        right &= x > (width - 1) * w
        over &= y < first_row * w
        under &= y > last_row * w
    ahead = max(corners[0, 2], corners[1, 2], corners[2, 2]) > 0
    return left or right or over or under or not ahead


@compiled
def _fill(
    inverse_depth: NDArray[np.float32],
    surface: NDArray[np.int32],
    lowest: NDArray[np.float32],
    corners: NDArray[np.float64],
    first_row: int,
    number: int,
    closed: bool,
    edges: NDArray[np.int64],
) -> None:
    """Draw one triangle of (x [px], y [px], inverse depth [1/m]) row by row.

    Of each edge a row needs floor(c / d): samples within are those x that are at most this, or at least its
    negative. From row to row c changes by a constant, so quotient and remainder follow without a division.
    """
    height, width = surface.shape
    x0, y0, x1 = round(_SUB * corners[0, 0]), round(_SUB * corners[0, 1]), round(_SUB * corners[1, 0])
    y1, x2, y2 = round(_SUB * corners[1, 1]), round(_SUB * corners[2, 0]), round(_SUB * corners[2, 1])
    area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
    if area == 0 or (closed and area > 0):  # clockwise in an image whose rows go down: a back
        return
    if area < 0:
        x1, y1, x2, y2 = x2, y2, x1, y1
    first = max(-(-min(y0, y1, y2) // _SUB), first_row)
    last = min(max(y0, y1, y2) // _SUB, first_row + height - 1)
    least = max(-(-min(x0, x1, x2) // _SUB), 0)
    most = min(max(x0, x1, x2) // _SUB, width - 1)
    if first > last or least > most:
        return
    nearest = np.float32(max(corners[0, 2], corners[1, 2], corners[2, 2]))
    farthest = np.float32(min(corners[0, 2], corners[1, 2], corners[2, 2]))
    if is_hidden(lowest, first - first_row, last - first_row, least, most, nearest):
        return

    _lay(edges[0], x0, y0, x1, y1, first)
    _lay(edges[1], x1, y1, x2, y2, first)
    _lay(edges[2], x2, y2, x0, y0, first)
    along_x, along_y = _slopes(corners)
    for y in range(first, last + 1):
        left, right = _next_span(edges, least, most)
        if left <= right:
            level = corners[0, 2] + along_x * (left - corners[0, 0]) + along_y * (y - corners[0, 1])
            row = y - first_row
            _fill_row(
                inverse_depth[row], surface[row], lowest[row], left, right, number,
                np.float32(level), np.float32(along_x), farthest, nearest,
            )  # fmt: skip


@inlined
def _lay(edge: NDArray[np.int64], ax: int, ay: int, bx: int, by: int, first: int) -> None:
    """Keep what the rows from `first` on need of the edge from a to b, in parts of a sample."""
    dx, dy = bx - ax, by - ay
    owns = dy < 0 or (dy == 0 and dx > 0)  # samples on left and top edges belong to the triangle
    c, divisor = dx * (_SUB * first - ay) + dy * ax - (0 if owns else 1), _SUB * max(abs(dy), 1)
    edge[_QUOTIENT], edge[_REST] = c // divisor, c % divisor
    edge[_MORE], edge[_MORE_REST] = (_SUB * dx) // divisor, (_SUB * dx) % divisor
    edge[_DIVISOR], edge[_SIDE] = divisor, np.sign(dy)


@inlined
def _next_span(edges: NDArray[np.int64], least: int, most: int) -> tuple[int, int]:
    """The first and last sample of a row that lie within all edges, which then go on to the next row."""
    left, right = least, most
    for edge in range(3):
        quotient = edges[edge, _QUOTIENT]
        if edges[edge, _SIDE] < 0:
            left = max(left, -quotient)
        elif edges[edge, _SIDE] > 0:
            right = min(right, quotient)
        elif quotient < 0:
            right = -1  # level, and the row lies beyond it
        edges[edge, _QUOTIENT] += edges[edge, _MORE]
        edges[edge, _REST] += edges[edge, _MORE_REST]
        if edges[edge, _REST] >= edges[edge, _DIVISOR]:
            edges[edge, _QUOTIENT] += 1
            edges[edge, _REST] -= edges[edge, _DIVISOR]
    return left, right


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
                here = level + slope * np.float32(start - left + x)
                here = min(max(here, farthest), nearest)
                before = depths[x]
                is_nearer = here > before
                depths[x] = here if is_nearer else before
                numbers[x] = own if is_nearer else numbers[x]
            if start == BLOCK * block and (end - start == BLOCK or end == len(surface)):
                lowest[block] = max(lowest[block], min(at_start, at_end))
        start = end


@compiled
def _slopes(corners: NDArray[np.float64]) -> tuple[float, float]:
    """Change of inverse depth per pixel along rows and along columns [1/m]."""
    ux, vx = corners[1, 0] - corners[0, 0], corners[2, 0] - corners[0, 0]
    uy, vy = corners[1, 1] - corners[0, 1], corners[2, 1] - corners[0, 1]
    uz, vz = corners[1, 2] - corners[0, 2], corners[2, 2] - corners[0, 2]
    twice_area = ux * vy - uy * vx
    if twice_area == 0:
        return 0.0, 0.0
    return (uz * vy - vz * uy) / twice_area, (ux * vz - vx * uz) / twice_area
