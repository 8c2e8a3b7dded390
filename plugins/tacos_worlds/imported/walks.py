"""Walks through an imported world, without end."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Fault, UserError
from tacos_worlds.imported.tour import along_waypoints, draw_tour, stepped_on, within
from tacos_worlds.imported.walkable_place import Place
from tacos_worlds.kit.walk.motion import Walk, draw_walk
from tacos_worlds.kit.walk.route import Route

_SHORTEST_M = 0.5
_FIRST_OBJECT = 1
"""What `tacos_worlds.kit.walk.trip.joined` adds to the number of a crossing."""


def draw_walks(
    rng: np.random.Generator,
    place: Place,
    waypoints_m: NDArray[np.float64],
    size_m: tuple[float, float] | None,
    speed_m_s: float,
    camera_height_m: tuple[float, float],
) -> Iterator[Walk]:
    """Walks, each on a way and at a height of its own: by waypoints, or tours of a piece of the floor."""
    piece = within(rng, place.floor, size_m)
    while True:
        if len(waypoints_m):
            try:
                line = along_waypoints(place.floor, waypoints_m)
            except ValueError as error:
                raise UserError(
                    Fault("scene.imported: waypoints_m", str(error), "places on the floor")
                ) from error
        else:
            line = draw_tour(rng, piece)
        length_m = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
        if length_m < _SHORTEST_M:
            raise UserError(
                Fault(
                    "scene.imported",
                    f"the floor has {piece.area_m2:.2f} m2 to walk on, too little for a way",
                    remedy="Leave closed doors out (leave_out), set start_m, or a smaller radius_m.",
                )
            )
        step_m = place.agent.step_m
        way = stepped_on(
            place.occlusion,
            place.object_of_triangle,
            line,
            place.obstacles,
            above_m=step_m + 0.05,
            reach_m=2 * step_m + 0.1,
        )
        route = Route(line[:, :2], tuple((point, thing - _FIRST_OBJECT) for point, thing in way.steps_on))
        height_m = float(rng.uniform(*camera_height_m))
        yield draw_walk(
            rng,
            route,
            speed_m_s=speed_m_s,
            camera_height_m=height_m,
            floor_m=np.ascontiguousarray(line[:, 2]),
        )
