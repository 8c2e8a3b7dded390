"""People: bodies as large as bodies are, closed, on their feet or on their seats."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_worlds.indoor.building import Building
from tacos_worlds.kit.people.clothes import draw_clothes
from tacos_worlds.kit.people.person import Build, draw_build, draw_person, person
from tacos_worlds.kit.people.pose import Pose, joints_of, seated, standing, walking
from tacos_worlds.kit.piece import Seat
from tests.worlds.solids import solid

seeds = st.integers(0, 100_000)


@given(seeds, st.sampled_from([standing, walking]), st.sampled_from([6, 10]))
@settings(max_examples=25, deadline=None)
def test_who_is_upright_stands_on_the_ground_and_is_as_tall_as_people_are(seed, pose, sides) -> None:
    rng = np.random.default_rng(seed)
    made = draw_person(rng, pose(rng), outdoors=True, sides=sides)
    low, high = made.bounds_m
    assert low[2] == pytest.approx(0, abs=1e-9)
    assert 1.0 < high[2] < 2.05
    wide, deep = (high - low)[:2]
    assert 0.3 < wide < 0.9
    assert deep < 1.1
    assert sum(len(mesh.triangles) for mesh, _ in made.parts) < (1100 if sides == 10 else 600)


@given(seeds, st.floats(0.40, 0.52))
@settings(max_examples=25, deadline=None)
def test_who_sits_has_hips_on_the_seat_and_feet_on_or_above_the_floor(seed, seat_m) -> None:
    rng = np.random.default_rng(seed)
    build = draw_build(rng, sides=8)
    pose = seated(rng, build.height_m, seat_m=seat_m, back_deg=10)
    low, high = person(build, pose, draw_clothes(rng, outdoors=False, cloth="")).bounds_m
    assert -0.05 < low[2] + seat_m < 0.3  # children's feet dangle
    assert 0.5 < high[2] < 1.05
    assert high[1] < 0.8  # knees and feet before the seat


@given(seeds)
@settings(max_examples=10, deadline=None)
def test_a_body_is_made_of_closed_surfaces_that_face_outwards(seed) -> None:
    rng = np.random.default_rng(seed)
    made = draw_person(rng, standing(rng))
    for mesh, _ in made.parts:
        assert solid(mesh).is_watertight
        assert solid(mesh).volume > 0


def test_one_state_makes_one_person() -> None:
    first, second = (draw_person(np.random.default_rng(4), Pose()) for _ in range(2))
    for (a, finish), (b, other) in zip(first.parts, second.parts, strict=True):
        assert np.array_equal(a.vertices_m, b.vertices_m)
        assert finish == other


def test_limbs_keep_their_length_in_every_pose() -> None:
    # Drillis and Contini: thigh 0.245, shank 0.246 and upper arm about 0.18 of the height.
    rng = np.random.default_rng(2)
    for pose in (Pose(), walking(rng), seated(rng, 1.8, seat_m=0.45, back_deg=10)):
        at = joints_of(pose, 1.8)
        for a, b, share in (
            (at.hip, at.knee, 0.245),
            (at.knee, at.ankle, 0.246),
            (at.shoulder, at.elbow, 0.18),
        ):
            assert np.linalg.norm(a - b, axis=1) == pytest.approx([share * 1.8] * 2, rel=1e-6)


def test_children_have_heads_as_large_as_those_of_adults() -> None:
    def head_m(height: float) -> float:
        made = person(
            Build(height, 1.0, 8), Pose(), draw_clothes(np.random.default_rng(1), outdoors=False, cloth="")
        )
        hair = made.parts[-2][0].vertices_m
        return float(np.ptp(hair[:, 0]))

    assert head_m(1.2) > 0.8 * head_m(1.75)


def test_a_seat_turns_with_its_piece(buildings: list[Building]) -> None:
    base = next(m.piece for b in buildings for m in b.furniture if m.piece.class_name == "chair")
    (seat,) = base.seats
    (turned,) = base.turned(math.pi / 2).seats
    assert isinstance(turned, Seat)
    assert (turned.x_m, turned.y_m) == pytest.approx((-seat.y_m, seat.x_m))
    assert turned.yaw_rad - seat.yaw_rad == pytest.approx(math.pi / 2)


def test_people_leave_the_walkways_free(buildings: list[Building]) -> None:
    people = [(b, m) for b in buildings for m in b.furniture if m.piece.class_name == "person"]
    assert len(people) > 8
    for building, m in people:
        assert m.blocks
        assert not any(m.footprint.overlaps(door.zone(0.9)) for door in building.plan.doors)
        assert any(building.plan.clear(k).contains(m.footprint) for k in range(len(building.plan.cells)))


def test_bathrooms_are_left_alone(buildings: list[Building]) -> None:
    for building in buildings:
        room = building.room_kinds.index("bathroom")
        clear = building.plan.clear(room)
        inside = [m for m in building.furniture if clear.contains(m.footprint)]
        assert "person" not in {m.piece.class_name for m in inside}
