"""People in a room: on sofas and chairs, and standing about."""

from __future__ import annotations

import math

import numpy as np

from tacos_worlds.indoor.furnishing.arrangement import Arrangement, Member, member, together
from tacos_worlds.indoor.furnishing.occupancy import RoomFloor
from tacos_worlds.kit.people.clothes import draw_clothes
from tacos_worlds.kit.people.person import draw_build, draw_person, person
from tacos_worlds.kit.people.pose import seated, standing
from tacos_worlds.kit.piece import Piece, Seat

_SITTING = 0.65
"""Share of the people who sit, where there are seats."""
_CLOTH = "weave"
_SIDES = 9
_LEG_ROOM = ("meal", "desk")
"""Tables of these uses have room for legs underneath."""


def welcome(rng: np.random.Generator, floor: RoomFloor, *, people: float) -> None:
    """Bring people into a furnished room, a Poisson number of them.

    Who sits blocks the floor before the seat; who stands, a place away from the walls. Neither takes the
    way between the doors.
    """
    for _ in range(int(rng.poisson(people))):
        if rng.uniform() >= _SITTING or not _sit(rng, floor):
            made = draw_person(rng, standing(rng), cloth=_CLOTH, sides=_SIDES)
            floor.place_inside(
                rng, together([member(made, yaw_rad=rng.uniform(0, 2 * math.pi))]), spread=0.42
            )


def _sit(rng: np.random.Generator, floor: RoomFloor) -> bool:
    """Seat somebody on a free seat, if there is one; whether there was."""
    bases = [m for made in floor.placed for m in made.members]
    sitting = [m for m in bases if m.piece.class_name == "person"]
    seats = [(m, seat) for m in bases for seat in m.piece.seats]
    for k in rng.permutation(len(seats)).tolist():
        base, seat = seats[k]
        made = _sitter(rng, seat)
        if any(made.footprint.overlaps(other.footprint) for other in sitting):
            continue
        under = [
            base.footprint,
            *(m.footprint for m in bases if any(t.use in _LEG_ROOM for t in m.piece.tops)),
        ]
        if floor.add_blocking(Arrangement((made,)), over=under):
            return True
    return False


def _sitter(rng: np.random.Generator, seat: Seat) -> Member:
    build = draw_build(rng, sides=_SIDES)
    pose = seated(rng, build.height_m, seat_m=seat.height_m, back_deg=seat.back_deg)
    body: Piece = person(build, pose, draw_clothes(rng, outdoors=False, cloth=_CLOTH))
    made = body.turned(seat.yaw_rad).moved(seat.x_m, seat.y_m, seat.height_m)
    return member(made, blocks=True)
