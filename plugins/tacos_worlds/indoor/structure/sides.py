"""The four sides of a room, and what opens in them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tacos_worlds.indoor.floor_plan import FloorPlan
from tacos_worlds.kit.mesh import Floats, Mesh
from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.rectangle import Rect


@dataclass(frozen=True)
class Side:
    """One wall face of a room. Along it x runs to the right seen from the wall, y into the room."""

    x_m: float  # of the corner where the local x starts
    y_m: float
    length_m: float  # length of the face [m]
    yaw_rad: float  # turns local y into the direction into the room
    outer: bool  # true if the outside lies behind it

    def place(self, thing: Piece, along_m: float, from_wall_m: float = 0.0, z_m: float = 0.0) -> Piece:
        """A piece given in the side's frame around x = 0, set at a place along the wall."""
        x, y = self.point(along_m, from_wall_m)
        return thing.turned(self.yaw_rad).moved(x, y, z_m)

    def place_mesh(self, mesh: Mesh) -> Mesh:
        return mesh.turned(self.yaw_rad).moved(self.x_m, self.y_m)

    def point(self, along_m: float, from_wall_m: float) -> tuple[float, float]:
        """World (x, y) of a point in the side's frame [m]."""
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return (
            self.x_m + cos * along_m - sin * from_wall_m,
            self.y_m + sin * along_m + cos * from_wall_m,
        )

    def along(self, x_m: float, y_m: float) -> tuple[float, float]:
        """Coordinates (along, from the wall) of a world point [m]."""
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        dx, dy = x_m - self.x_m, y_m - self.y_m
        return cos * dx + sin * dy, -sin * dx + cos * dy

    def rect(self, low_m: float, high_m: float, near_m: float, far_m: float) -> Rect:
        """World rectangle from `low_m` to `high_m` along and `near_m` to `far_m` off the wall [m]."""
        corners = [self.point(low_m, near_m), self.point(high_m, far_m)]
        xs, ys = zip(*corners, strict=True)
        return Rect(min(xs), min(ys), max(xs), max(ys))


@dataclass(frozen=True)
class Opening:
    """A hole in a side, from `low_m` to `high_m` along and `sill_m` to `head_m` above the floor [m]."""

    low_m: float
    high_m: float
    sill_m: float
    head_m: float


def sides_of(plan: FloorPlan, room: int) -> list[Side]:
    """The four sides of a room: south, east, north, west."""
    clear = plan.clear(room)
    width, depth = clear.size
    return [
        Side(clear.x0, clear.y0, width, 0.0, clear.y0 == 0),
        Side(clear.x1, clear.y0, depth, math.pi / 2, clear.x1 == plan.size_m[0]),
        Side(clear.x1, clear.y1, width, math.pi, clear.y1 == plan.size_m[1]),
        Side(clear.x0, clear.y1, depth, -math.pi / 2, clear.x0 == 0),
    ]


def door_openings(plan: FloorPlan, room: int, side: Side, lining_m: float) -> list[Opening]:
    """The holes that the doors of a room make in one side, larger by their lining [m]."""
    found = []
    for door in plan.doors_of(room):
        along, off = side.along(door.x_m, door.y_m)
        if abs(off) < 0.2 and 0 < along < side.length_m:
            half = door.width_m / 2 + lining_m
            found.append(Opening(along - half, along + half, 0.0, door.height_m + lining_m))
    return found


def wall_face(side: Side, openings: list[Opening], low_m: float, high_m: float, step_m: float) -> Mesh:
    """The face between two heights, in cells of about `step_m`, with holes left out [m]."""
    columns = _breaks(
        [0.0, side.length_m, *(x for o in openings for x in (o.low_m, o.high_m))], 0, side.length_m, step_m
    )
    rows = _breaks(
        [low_m, high_m, *(z for o in openings for z in (o.sill_m, o.head_m))], low_m, high_m, step_m
    )
    s, z = np.meshgrid(columns, rows)
    points = np.column_stack([s.ravel(), np.zeros(s.size), z.ravel()])
    middle_s, middle_z = np.meshgrid((columns[:-1] + columns[1:]) / 2, (rows[:-1] + rows[1:]) / 2)
    solid = np.ones(middle_s.shape, bool)
    for hole in openings:
        solid &= ~(
            (middle_s > hole.low_m)
            & (middle_s < hole.high_m)
            & (middle_z > hole.sill_m)
            & (middle_z < hole.head_m)
        )
    row, column = np.nonzero(solid)
    count = len(columns)
    a = row * count + column
    b, c, d = a + 1, a + count + 1, a + count
    # The face looks along +y, so seen from inside x runs to the left.
    triangles = np.concatenate([np.stack([a, c, b], axis=1), np.stack([a, d, c], axis=1)])
    used, triangles = np.unique(triangles, return_inverse=True)
    mesh = Mesh(
        points[used],
        np.tile([0.0, 1.0, 0.0], (len(used), 1)),
        np.column_stack([-points[used, 0], points[used, 2]]),
        triangles.reshape(-1, 3),
    )
    return side.place_mesh(mesh)


def _breaks(fixed: list[float], low: float, high: float, step_m: float) -> Floats:
    """Sorted coordinates that hold all fixed ones and leave no gap much above `step_m`."""
    kept = sorted({round(min(max(value, low), high), 6) for value in fixed})
    cuts = [
        np.linspace(start, end, max(1, round((end - start) / step_m)) + 1)[:-1]
        for start, end in pairwise(kept)
    ]
    return np.concatenate([*cuts, [kept[-1]]])
