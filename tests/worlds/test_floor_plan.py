"""Floor plans: sizes, doors, connection."""

from __future__ import annotations

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_worlds.indoor.floor_plan import MAX_ROOMS, FloorPlan, draw_floor_plan

seeds = st.integers(0, 10_000)
sizes = st.tuples(st.floats(5.0, 24.0), st.floats(5.0, 24.0))


def plan_of(seed: int, size_m: tuple[float, float] = (15.0, 15.0)) -> FloorPlan:
    return draw_floor_plan(np.random.default_rng(seed), size_m, 5.0)


@given(seed=seeds, size=sizes)
@settings(max_examples=60, deadline=None)
def test_rooms_tile_the_floor_and_keep_their_least_edge(seed: int, size: tuple[float, float]) -> None:
    plan = plan_of(seed, size)
    assert min(min(cell.size) for cell in plan.cells) >= 5.0 - 1e-9
    assert sum(w * d for w, d in (cell.size for cell in plan.cells)) == pytest.approx(size[0] * size[1])
    for k, cell in enumerate(plan.cells):
        assert not any(cell.grown(-0.01).overlaps(other) for other in plan.cells[k + 1 :])
    assert len(plan.cells) <= MAX_ROOMS


@given(seed=seeds, size=sizes)
@settings(max_examples=60, deadline=None)
def test_every_room_can_be_reached(seed: int, size: tuple[float, float]) -> None:
    plan = plan_of(seed, size)
    graph = nx.Graph()
    graph.add_nodes_from(range(len(plan.cells)))
    graph.add_edges_from(door.rooms for door in plan.doors)
    assert nx.is_connected(graph)


@given(seed=seeds)
@settings(max_examples=40, deadline=None)
def test_doors_lie_in_the_wall_between_their_rooms(seed: int) -> None:
    plan = plan_of(seed)
    for door in plan.doors:
        for room, way in zip(door.rooms, (-1, 1), strict=True):
            clear = plan.clear(room)
            x, y = door.position_m + way * 0.3 * door.direction
            assert clear.x0 < x < clear.x1
            assert clear.y0 < y < clear.y1
        assert 0.85 < door.width_m < 1.05


def test_plans_differ_in_number_and_size_of_rooms() -> None:
    counts = {len(plan_of(seed).cells) for seed in range(40)}
    assert counts >= {4, 5, 6}
    assert len({plan_of(seed).cells for seed in range(40)}) > 30
