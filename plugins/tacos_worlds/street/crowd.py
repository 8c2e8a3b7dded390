"""People and parked cars of a town of a limited number of triangles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from tacos_framework import Trajectory
from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.rectangle import Rect
from tacos_worlds.street.city import Town, kerbs
from tacos_worlds.street.people import PERSON_TRIANGLES, draw_pedestrians
from tacos_worlds.street.streetscape import PlacedPiece, triangles_of

TRIANGLES = 100_000
"""A town has about so many; the largest have more, as houses and roads alone fill it."""
_LIFE_TRIANGLES = 12_000
"""Left to parked cars where houses and roads have used up the rest."""
_CAR_TRIANGLES = 350
_NEAR_M = 70.0
"""What stands farther from the agent's way than this is small in its pictures [m]."""
_HEADROOM_M = 2.3


def populated(
    rng: np.random.Generator,
    town: Town,
    placed: list[PlacedPiece],
    *,
    way_m: NDArray[np.float64],
    people: int,
    duration_s: float,
    driving: int,
) -> tuple[list[PlacedPiece], list[tuple[Piece, Trajectory]]]:
    """A furnished town with people in it, and with fewer parked cars where it has too many triangles.

    People are where the agent passes, and the cars that it never comes near go first.

    - `way_m`: (N, 2) places that the agent passes [m].
    - `people`: how many there should be, standing and walking.
    - `driving`: how many cars drive, which count too.

    Returns: what stands still, and each who walks with the way from where he or she rests.
    """
    kerb_rng, car_rng = rng.spawn(2)
    still = [thing for thing in placed if thing.piece.class_name != "car"]
    spare = TRIANGLES - triangles_of(still) - driving * _CAR_TRIANGLES - people * PERSON_TRIANGLES
    passed = cKDTree(way_m)
    inner = [kerb for kerb in kerbs(town) if kerb.inner]
    near = [kerb for kerb in inner if passed.query(kerb.point(kerb.length_m / 2, 0.0))[0] < _NEAR_M]
    found = draw_pedestrians(kerb_rng, near or inner, _obstacles(still), duration_s, people)
    kept = _thinned(car_rng, placed, triangles_of(still) + max(spare, _LIFE_TRIANGLES), passed)
    standing = [PlacedPiece(someone.piece) for someone in found if someone.trajectory is None]
    walking = [(someone.piece, someone.trajectory) for someone in found if someone.trajectory is not None]
    return [*kept, *standing], walking


def _thinned(
    rng: np.random.Generator, placed: list[PlacedPiece], triangles: int, passed: cKDTree
) -> list[PlacedPiece]:
    """A town without as many of its parked cars as are too many: those far off first."""
    cars = np.array([k for k, thing in enumerate(placed) if thing.piece.class_name == "car"], np.int64)
    middles = np.array([_middle(placed[k]) for k in cars.tolist()]).reshape(-1, 2)
    far = np.asarray(passed.query(middles)[0]) > _NEAR_M
    order = np.lexsort((rng.permutation(len(cars)), ~far))
    surplus, gone = triangles_of(placed) - triangles, set()
    for k in cars[order].tolist():
        if surplus <= 0:
            break
        surplus -= triangles_of([placed[k]])
        gone.add(k)
    return [thing for k, thing in enumerate(placed) if k not in gone]


def _middle(thing: PlacedPiece) -> NDArray[np.float64]:
    low, high = thing.piece.bounds_m
    return np.asarray((low + high)[:2] / 2)


def _obstacles(placed: Sequence[PlacedPiece]) -> list[Rect]:
    """Footprints of what stands in the way of people: all but the ground and the rows of houses [m]."""
    found = []
    for thing in placed:
        if thing.piece.class_name in ("road", "pavement", "vegetation", "building", "car"):
            continue
        # The crowns of trees and the arms of lamps are over people's heads.
        low = np.concatenate([mesh.vertices_m for mesh, _ in thing.piece.parts])
        low = low[low[:, 2] < _HEADROOM_M]
        (x0, y0), (x1, y1) = low[:, :2].min(axis=0).tolist(), low[:, :2].max(axis=0).tolist()
        found.append(Rect(x0, y0, x1, y1))
    return found
