"""Roads with their markings, and the pavements and yards of blocks."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tacos_worlds.kit.mesh import Mesh, merged
from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.rectangle import Rect
from tacos_worlds.street.city import CARRIAGEWAY_M, CORNER_M, KERB_M, LANE_M, PAVEMENT_M, Town, building_line
from tacos_worlds.street.finishes import ASPHALT, GRASS, KERB, PAINT, SLABS
from tacos_worlds.street.panels import fan, ground, upright

_HALF_M = CARRIAGEWAY_M / 2
_LIFT_M = 0.012
"""Paint lies this high on the road, so that depth buffers tell the two apart [m]."""
_STEP_M = 12.0
_KERB_WIDTH_M = 0.15
_ARC_STEPS = 5
ZEBRA_M = (CORNER_M + 0.6, CORNER_M + 3.6)
"""Where a zebra crossing lies, from the edge of the crossing street [m]."""
STOP_LINE_M = ZEBRA_M[1] + 0.8
"""Where cars stop, from the edge of the crossing street [m]."""


def roads(town: Town) -> list[Piece]:
    """One piece a street, crossings with the streets along x."""
    extent = town.extent
    pieces = []
    for y in town.street_y_m:
        surface = [ground((extent.x0, extent.x1), (y - _HALF_M, y + _HALF_M), 0.0, step_m=_STEP_M)]
        for x in town.street_x_m:
            for sign in (-1, 1):
                span = sorted((y + sign * _HALF_M, y + sign * (_HALF_M + CORNER_M)))
                reach = _HALF_M + CORNER_M
                surface.append(ground((x - reach, x + reach), (span[0], span[1]), 0.0, step_m=_STEP_M))
        paint = list(_markings(town.street_x_m, (extent.x0, extent.x1)))
        pieces.append(
            Piece("road", ((merged(surface), ASPHALT), (merged(paint).moved(0, y, _LIFT_M), PAINT)))
        )
    for x in town.street_x_m:
        ends = (extent.y0 - _HALF_M - CORNER_M, *town.street_y_m, extent.y1 + _HALF_M + CORNER_M)
        surface = [
            ground(
                (x - _HALF_M, x + _HALF_M),
                (low + _HALF_M + CORNER_M, high - _HALF_M - CORNER_M),
                0.0,
                step_m=_STEP_M,
            )
            for low, high in pairwise(ends)
        ]
        paint = list(_markings(town.street_y_m, (extent.y0, extent.y1)))
        turned = merged(paint).turned(np.pi / 2).moved(x, 0, _LIFT_M)
        pieces.append(Piece("road", ((merged(surface), ASPHALT), (turned, PAINT))))
    return pieces


def _markings(crossings_m: tuple[float, ...], ends_m: tuple[float, float]) -> Iterator[Mesh]:
    ends = (ends_m[0], *crossings_m, ends_m[1])
    for number, (low, high) in enumerate(pairwise(ends)):
        clear = [low, high]
        for side, at, inwards in ((0, low, 1), (1, high, -1)):
            if (number, side) in ((0, 0), (len(ends) - 2, 1)):
                continue  # an end of the street
            edge = at + inwards * _HALF_M
            near, far = (edge + inwards * z for z in ZEBRA_M)
            stripes = np.arange(-_HALF_M + 0.35, _HALF_M - 0.3, 1.0)
            for y in stripes:
                yield ground((min(near, far), max(near, far)), (y, y + 0.5), 0.0)
            stop = edge + inwards * STOP_LINE_M
            lane = (-LANE_M, -0.1) if inwards < 0 else (0.1, LANE_M)
            yield ground((min(stop, stop + 0.4 * inwards), max(stop, stop + 0.4 * inwards)), lane, 0.0)
            clear[side] = stop + inwards * 1.5
        for x in np.arange(clear[0], clear[1] - 3.0, 6.0):
            yield ground((x, x + 3.0), (-0.07, 0.07), 0.0)
        for x in np.arange(clear[0] + 4.0, clear[1] - 4.0, 6.0):
            for y in (-LANE_M, LANE_M):
                yield ground((x, x + 1.0), (y - 0.05, y + 0.05), 0.0)


def pavement(block: Rect) -> Piece:
    outer = rounded(block, CORNER_M)
    inner = rounded(block.grown(-_KERB_WIDTH_M), CORNER_M - _KERB_WIDTH_M)
    stones = merged([upright(outer, (0.0, KERB_M), closed=True), _ring(outer, inner)])
    return Piece("pavement", ((stones, KERB), (_walk(block), SLABS)))


def _walk(block: Rect) -> Mesh:
    k, z = _KERB_WIDTH_M, KERB_M
    line, c = building_line(block), PAVEMENT_M
    strips = [
        ground((line.x0, line.x1), (block.y0 + k, line.y0), z, step_m=_STEP_M),
        ground((line.x0, line.x1), (line.y1, block.y1 - k), z, step_m=_STEP_M),
        ground((block.x0 + k, line.x0), (line.y0, line.y1), z, step_m=_STEP_M),
        ground((line.x1, block.x1 - k), (line.y0, line.y1), z, step_m=_STEP_M),
    ]
    arcs = rounded(block.grown(-k), c - k).reshape(4, _ARC_STEPS + 1, 2)
    corners = [(line.x1, line.y1), (line.x0, line.y1), (line.x0, line.y0), (line.x1, line.y0)]
    strips += [fan(np.vstack([arc, corner]), z) for arc, corner in zip(arcs, corners, strict=True)]
    return merged(strips)


def yard(block: Rect) -> Piece:
    """Grass behind the buildings, or the lawn of a park."""
    line = building_line(block)
    return Piece(
        "vegetation", ((ground((line.x0, line.x1), (line.y0, line.y1), KERB_M - 0.01, step_m=24.0), GRASS),)
    )


def rounded(rect: Rect, radius_m: float) -> NDArray[np.float64]:
    """(4 (S + 1), 2) outline with round corners, counter-clockwise from that of greatest x and y [m]."""
    turn = np.linspace(0, np.pi / 2, _ARC_STEPS + 1)
    points = []
    for quarter, (x, y) in enumerate(
        (
            (rect.x1 - radius_m, rect.y1 - radius_m),
            (rect.x0 + radius_m, rect.y1 - radius_m),
            (rect.x0 + radius_m, rect.y0 + radius_m),
            (rect.x1 - radius_m, rect.y0 + radius_m),
        )
    ):
        angle = turn + quarter * np.pi / 2
        points.append(np.column_stack([x + radius_m * np.cos(angle), y + radius_m * np.sin(angle)]))
    return np.concatenate(points)


def _ring(outer: NDArray[np.float64], inner: NDArray[np.float64]) -> Mesh:
    """The level strip between two outlines of equally many corners, at the height of the pavement."""
    count = len(outer)
    here, after = np.arange(count), (np.arange(count) + 1) % count
    points = np.column_stack([np.vstack([outer, inner]), np.full(2 * count, KERB_M)])
    run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(outer, axis=0), axis=1))])
    across = np.repeat([0.0, _KERB_WIDTH_M], count)
    return Mesh(
        vertices_m=points,
        normals=np.tile([0.0, 0.0, 1.0], (len(points), 1)),
        uv_m=np.column_stack([np.tile(run, 2), across]),
        triangles=np.concatenate(
            [
                np.column_stack([here, after, after + count]),
                np.column_stack([here, after + count, here + count]),
            ]
        ),
    )
