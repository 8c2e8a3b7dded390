"""Walks through all rooms of a building."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tacos_worlds.indoor.building import Building
from tacos_worlds.indoor.walk.free_space import FreeSpace
from tacos_worlds.indoor.walk.route import draw_route
from tacos_worlds.kit.walk.motion import Walk, draw_walk


def draw_walks(
    rng: np.random.Generator, building: Building, speed_m_s: float, camera_height_m: tuple[float, float]
) -> Iterator[Walk]:
    """Walks through all rooms without end, each on a way and at a height of its own."""
    free = FreeSpace(building)
    while True:
        route = draw_route(rng, building, free)
        height_m = float(rng.uniform(*camera_height_m))
        yield draw_walk(rng, route, speed_m_s=speed_m_s, camera_height_m=height_m)
