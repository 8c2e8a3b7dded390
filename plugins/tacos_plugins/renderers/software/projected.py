"""Triangles on an image: which of them can show, which samples they may cover, and how far away they are.

What follows from a view alone is found here, once; `visibility` then draws band after band of its rows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.compiled.loops import compiled
from tacos_plugins.renderers.software.clipping import CORNERS, cut, needs_cutting

SUB = 256
"""Places a sample's width is divided into."""

# Columns of `Projected.places`, after the six of the corners.
FIRST_ROW, LAST_ROW, FIRST_COLUMN, LAST_COLUMN, TRIANGLE = range(6, 11)
# Columns of `Projected.inverse_depth`.
X, Y, LEVEL, ALONG_X, ALONG_Y, FARTHEST, NEAREST = range(7)


class Projected(NamedTuple):
    """Triangles that may show in an image, first those that are drawn first."""

    places: NDArray[np.int64]
    """(N, 11) int64: x and y of three corners, clockwise in an image whose rows go down [1/256 px]; first and
    last row, first and last column of the samples among them [px]; number of the triangle, from 1.
    """
    inverse_depth: NDArray[np.float64]
    """(N, 7) float64: x and y of a corner [px], inverse depth there [1/m], its change along rows and columns
    [1/m/px], and the least and greatest inverse depth [1/m].
    """


def project(
    position_m: NDArray[np.float32],
    triangles: NDArray[np.int32],
    runs: NDArray[np.int64],
    pixel_from_world: NDArray[np.float64],
    shape: tuple[int, int],
    near_m: float,
    closed: bool,
) -> Projected:
    """Find the triangles of some runs on an image.

    - `position_m`: (V, 3) places of vertices [m].
    - `triangles`: (T, 3) vertices of each triangle.
    - `runs`: (R, 2) first triangle and number of triangles of each run.
    - `pixel_from_world`: (3, 4) see `Viewpoint`.
    - `shape`: rows and columns of the image [px].
    - `near_m`: what is nearer is cut off [m].
    - `closed`: whether backs are never seen, and need not be drawn.
    """
    room = 2 * int(runs[:, 1].sum()) + CORNERS
    while True:
        places, inverse_depth = np.empty((room, 11), np.int64), np.empty((room, 7))
        mesh = (position_m, triangles, runs)
        found = _project(*mesh, pixel_from_world, shape, near_m, closed, places, inverse_depth)
        if found >= 0:
            return Projected(places[:found], inverse_depth[:found])
        room *= CORNERS  # nearly all of them were cut


@compiled
def _project(
    position_m: NDArray[np.float32],
    triangles: NDArray[np.int32],
    runs: NDArray[np.int64],
    pixel_from_world: NDArray[np.float64],
    shape: tuple[int, int],
    near_m: float,
    closed: bool,
    places: NDArray[np.int64],
    inverse_depth: NDArray[np.float64],
) -> int:
    """Fill in what `project` gives; how many there are, or -1 where there is no room for all."""
    corners, spare = np.empty((CORNERS, 3)), np.empty((CORNERS, 3))
    found = 0
    for run in range(len(runs)):
        for triangle in range(runs[run, 0], runs[run, 0] + runs[run, 1]):
            for corner in range(3):
                vertex = triangles[triangle, corner]
                x, y, z = position_m[vertex, 0], position_m[vertex, 1], position_m[vertex, 2]
                for axis in range(3):
                    row = pixel_from_world[axis]
                    corners[corner, axis] = row[0] * x + row[1] * y + row[2] * z + row[3]
            if _beyond(corners, shape):
                continue
            count = 3
            if needs_cutting(corners, near_m):
                count = cut(corners, spare, near_m)
            for corner in range(count):
                inverse = 1 / corners[corner, 2]
                corners[corner, 0] *= inverse
                corners[corner, 1] *= inverse
                corners[corner, 2] = inverse
            if found + count > len(places):
                return -1
            for corner in range(2, count):
                for axis in range(3):
                    spare[0, axis] = corners[0, axis]
                    spare[1, axis] = corners[corner - 1, axis]
                    spare[2, axis] = corners[corner, axis]
                if _place(places[found], spare, shape, closed):
                    places[found, TRIANGLE] = triangle + 1
                    _level(inverse_depth[found], spare)
                    found += 1
    return found


@compiled
def _beyond(corners: NDArray[np.float64], shape: tuple[int, int]) -> bool:
    """True if a triangle of homogeneous pixels lies beyond one side of an image, and so shows nowhere."""
    left, right, over, under = True, True, True, True
    for corner in range(3):
        x, y, w = corners[corner, 0], corners[corner, 1], corners[corner, 2]
        left &= x < 0
        right &= x > (shape[1] - 1) * w
        over &= y < 0
        under &= y > (shape[0] - 1) * w
    ahead = max(corners[0, 2], corners[1, 2], corners[2, 2]) > 0
    return left or right or over or under or not ahead


@compiled
def _place(
    places: NDArray[np.int64], corners: NDArray[np.float64], shape: tuple[int, int], closed: bool
) -> bool:
    """Fill in where a triangle of (x [px], y [px], inverse depth [1/m]) lies; whether it may be seen."""
    x0, y0, x1 = round(SUB * corners[0, 0]), round(SUB * corners[0, 1]), round(SUB * corners[1, 0])
    y1, x2, y2 = round(SUB * corners[1, 1]), round(SUB * corners[2, 0]), round(SUB * corners[2, 1])
    area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
    if area == 0 or (closed and area > 0):  # clockwise in an image whose rows go down: a back
        return False
    if area < 0:
        x1, y1, x2, y2 = x2, y2, x1, y1
    places[0], places[1], places[2], places[3], places[4], places[5] = x0, y0, x1, y1, x2, y2
    places[FIRST_ROW] = max(-(-min(y0, y1, y2) // SUB), 0)
    bottom = max(y0, y1, y2)
    # Samples on a level edge at the bottom belong to the next triangle.
    ends_level = (y0 == bottom) + (y1 == bottom) + (y2 == bottom) > 1
    places[LAST_ROW] = min((bottom - 1 if ends_level else bottom) // SUB, shape[0] - 1)
    places[FIRST_COLUMN] = max(-(-min(x0, x1, x2) // SUB), 0)
    places[LAST_COLUMN] = min(max(x0, x1, x2) // SUB, shape[1] - 1)
    return places[FIRST_ROW] <= places[LAST_ROW] and places[FIRST_COLUMN] <= places[LAST_COLUMN]


@compiled
def _level(inverse_depth: NDArray[np.float64], corners: NDArray[np.float64]) -> None:
    """Fill in how far away a triangle is."""
    ux, vx = corners[1, 0] - corners[0, 0], corners[2, 0] - corners[0, 0]
    uy, vy = corners[1, 1] - corners[0, 1], corners[2, 1] - corners[0, 1]
    uz, vz = corners[1, 2] - corners[0, 2], corners[2, 2] - corners[0, 2]
    twice_area = ux * vy - uy * vx
    inverse_depth[X], inverse_depth[Y], inverse_depth[LEVEL] = corners[0, 0], corners[0, 1], corners[0, 2]
    inverse_depth[ALONG_X], inverse_depth[ALONG_Y] = 0.0, 0.0
    if twice_area != 0:
        inverse_depth[ALONG_X] = (uz * vy - vz * uy) / twice_area
        inverse_depth[ALONG_Y] = (ux * vz - vx * uz) / twice_area
    inverse_depth[FARTHEST] = min(corners[0, 2], corners[1, 2], corners[2, 2])
    inverse_depth[NEAREST] = max(corners[0, 2], corners[1, 2], corners[2, 2])
