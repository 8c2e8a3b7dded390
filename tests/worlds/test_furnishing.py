"""Furniture stands where it can: clear of each other, of doors and of walls."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from tacos_worlds.indoor.building import MAX_LIGHTS, Building, draw_building
from tacos_worlds.indoor.furnishing.arrangement import Arrangement, Member
from tacos_worlds.indoor.furnishing.catalogue import Catalogue
from tacos_worlds.indoor.furnishing.rooms import draw_room_kinds
from tacos_worlds.kit.class_names import FURNITURE_CLASSES


def bounds(member: Member) -> tuple[np.ndarray, np.ndarray]:
    low, high = member.piece.bounds_m
    return low + 1e-6, high - 1e-6


def seated(member: Member) -> bool:
    """Whether somebody sits there: hips and legs share the bounds of the seat, and of a table."""
    low, high = member.piece.bounds_m
    return member.piece.class_name == "person" and high[2] - low[2] < 1.5 and high[2] < 1.6


def stands_on_top(thing: Member, base: Member) -> bool:
    """Whether a thing stands on a top of a piece."""
    low = thing.piece.bounds_m[0][2]
    return any(abs(t.height_m - low) < 1e-6 and t.rect.contains(thing.footprint) for t in base.piece.tops)


def test_no_two_pieces_of_furniture_meet(buildings: list[Building]) -> None:
    for building in buildings:
        solid = [(m, *bounds(m)) for m in building.furniture if not m.flat and not seated(m)]
        for (a, low, high), (b, other_low, other_high) in combinations(solid, 2):
            if stands_on_top(a, b) or stands_on_top(b, a):
                continue  # as a bottle on a worktop, below the cupboards of the same kitchen
            assert not (np.all(low < other_high) and np.all(other_low < high))


def test_no_two_rugs_overlap(buildings: list[Building]) -> None:
    for building in buildings:
        rugs = [m.footprint for m in building.furniture if m.flat]
        assert not any(a.overlaps(b) for a, b in combinations(rugs, 2))


def test_nothing_floats_or_sinks(buildings: list[Building]) -> None:
    for building in buildings:
        tops = [m for m in building.furniture if m.blocks]
        for m in building.furniture:
            if seated(m):
                continue
            low = m.piece.bounds_m[0][2]
            under = [t for t in tops if t is not m and t.footprint.overlaps(m.footprint)]
            if m.blocks or m.flat:
                assert low == pytest.approx(0, abs=1e-6)
            else:
                on_tops = any(
                    low == pytest.approx(top.height_m, abs=1e-6) for t in under for top in t.piece.tops
                )
                assert on_tops or any(low == pytest.approx(t.height_m, abs=0.08) for t in under)


def test_furniture_stays_inside_its_room_and_out_of_doorways(buildings: list[Building]) -> None:
    for building in buildings:
        plan = building.plan
        rooms = [plan.clear(room) for room in range(len(plan.cells))]
        for m in building.furniture:
            assert any(room.grown(1e-6).contains(m.footprint) for room in rooms)
            if m.blocks:
                assert not any(m.footprint.overlaps(door.zone(0.95)) for door in plan.doors)
                assert not any(m.footprint.overlaps(leaf) for leaf in building.leaves)


def test_every_door_has_one_threshold_low_and_across_the_opening(buildings: list[Building]) -> None:
    for building in buildings:
        assert len(building.thresholds) == len(building.plan.doors)
        for door, sill in zip(building.plan.doors, building.thresholds, strict=True):
            low, high = sill.bounds_m
            assert sill.class_name == "threshold"
            assert (low + high)[:2] / 2 == pytest.approx(door.position_m, abs=1e-6)
            assert 0.02 < high[2] - low[2] < 0.05
            assert high[1 - door.axis] - low[1 - door.axis] == pytest.approx(door.width_m, abs=0.01)
            assert high[door.axis] - low[door.axis] < 0.3


def triangles(building: Building) -> int:
    pieces = [*building.background, *building.thresholds, *(m.piece for m in building.furniture)]
    return sum(len(mesh.triangles) for thing in pieces for mesh, _ in thing.parts)


def test_triangles_stay_in_their_budget(buildings: list[Building]) -> None:
    assert max(map(triangles, buildings)) < 100_000


@pytest.mark.parametrize("size_m", [(30.0, 12.0), (24.0, 24.0), (5.0, 5.0)])
def test_large_cluttered_floors_keep_the_budget_too(size_m: tuple[float, float]) -> None:
    crowded = draw_building(
        np.random.default_rng(107),
        size_m=size_m,
        ceiling_height_m=4.0,
        min_room_m=4.0,
        clutter=1.0,
        people=1.0,
        catalogue=Catalogue(),
    )
    assert triangles(crowded) <= 100_000


def test_all_ten_classes_appear(buildings: list[Building]) -> None:
    seen = {m.piece.class_name for building in buildings for m in building.furniture}
    assert seen >= set(FURNITURE_CLASSES)
    for building in buildings:
        assert len({m.piece.class_name for m in building.furniture} & set(FURNITURE_CLASSES)) >= 8


def test_lights_stay_few(buildings: list[Building]) -> None:
    for building in buildings:
        pieces = [*building.background, *(m.piece for m in building.furniture)]
        count = sum(len(thing.lights) for thing in pieces)
        assert len(building.plan.cells) <= count <= MAX_LIGHTS


def test_rooms_look_furnished(buildings: list[Building]) -> None:
    for building in buildings:
        for room in range(len(building.plan.cells)):
            clear = building.plan.clear(room)
            inside = [m for m in building.furniture if m.blocks and clear.contains(m.footprint)]
            assert len(inside) >= 4


@pytest.mark.parametrize("count", [1, 2, 4, 6, 9])
def test_room_kinds_for_any_number_of_rooms(count: int) -> None:
    kinds = draw_room_kinds(np.random.default_rng(count), [25.0 + k for k in range(count)])
    assert len(kinds) == count
    assert kinds[-1] == "living"
    if count >= 3:
        assert kinds[0] == "bathroom"


def test_an_arrangement_turns_its_footprints_with_its_pieces(buildings: list[Building]) -> None:
    member = next(m for m in buildings[0].furniture if m.blocks)
    for turns in range(4):
        placed = Arrangement((member,)).set_at(2.0, -1.0, turns).members[0]
        low, high = placed.piece.bounds_m
        f = placed.footprint
        assert [f.x0, f.y0, f.x1, f.y1] == pytest.approx([*low[:2], *high[:2]], abs=1e-9)
