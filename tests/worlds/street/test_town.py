"""Towns before they are lit: streets, what stands in them, budgets."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_worlds.street.assembly import CLASS_NAMES
from tacos_worlds.street.city import CARRIAGEWAY_M, LANE_M, PARKING_M, Town, draw_town, kerbs
from tacos_worlds.street.ground import pavement
from tacos_worlds.street.streetscape import PlacedPiece, furnish_town
from tacos_worlds.street.things.vehicles import BODIES, car, draw_car


def town(seed: int, blocks: int = 3) -> Town:
    return draw_town(np.random.default_rng(seed), blocks=blocks, reach_m=160.0)


def furnished(seed: int, blocks: int = 3) -> tuple[Town, list[PlacedPiece]]:
    place = town(seed, blocks)
    rng = np.random.default_rng(seed)
    return place, furnish_town(rng, place, greenery=0.3, parked_share=0.15)


@pytest.fixture(scope="module")
def full() -> tuple[Town, list[PlacedPiece]]:
    return furnished(3)


def to_nearest_street_m(place: Town, points: np.ndarray) -> np.ndarray:
    across_x = np.abs(points[:, :1] - np.array(place.street_x_m)).min(axis=1)
    across_y = np.abs(points[:, 1:2] - np.array(place.street_y_m)).min(axis=1)
    return np.minimum(across_x, across_y)


@given(st.integers(0, 10_000), st.integers(1, 4))
@settings(max_examples=30, deadline=None)
def test_blocks_and_streets_share_the_land(seed: int, blocks: int) -> None:
    place = town(seed, blocks)
    assert len(place.inner_blocks()) == blocks**2
    assert len(place.outer_blocks()) == (blocks + 2) ** 2 - blocks**2
    for block in (*place.inner_blocks(), *place.outer_blocks()):
        assert min(block.size) > 20
        middle = np.array([block.centre])
        assert to_nearest_street_m(place, middle)[0] > CARRIAGEWAY_M / 2


def test_towns_of_different_seeds_have_different_streets() -> None:
    layouts = {town(seed).street_x_m for seed in range(5)}
    assert len(layouts) == 5


def test_triangles_stay_within_their_budget(full: tuple[Town, list[PlacedPiece]]) -> None:
    _, placed = full
    triangles = sum(len(mesh.triangles) for thing in placed for mesh, _ in thing.piece.parts)
    assert 60_000 < triangles < 110_000


def test_the_driving_lanes_are_free(full: tuple[Town, list[PlacedPiece]]) -> None:
    place, placed = full
    for thing in placed:
        piece = thing.piece
        if piece.class_name in ("road", "vegetation"):
            continue
        points = np.concatenate([mesh.vertices_m for mesh, _ in piece.parts])
        low = points[points[:, 2] < 4.5]  # footbridges and lamps reach over the road higher up
        assert to_nearest_street_m(place, low).min() > LANE_M - 0.2, piece.class_name


def test_parked_cars_stand_in_their_bays_and_do_not_touch(full: tuple[Town, list[PlacedPiece]]) -> None:
    place, placed = full
    boxes = []
    for thing in placed:
        if thing.piece.class_name == "car":
            low, high = thing.piece.bounds_m
            middle = ((low + high) / 2)[None]
            off = to_nearest_street_m(place, middle)[0]
            assert LANE_M < off < LANE_M + PARKING_M
            boxes.append((low[:2], high[:2]))
    assert len(boxes) > 20
    low, high = (np.array([box[k] for box in boxes]) for k in (0, 1))
    overlap = (low[:, None] < high[None]).all(axis=2) & (low[None] < high[:, None]).all(axis=2)
    assert overlap.sum() == len(boxes)  # each with itself


def test_buildings_stand_behind_the_pavement_and_close_every_street(
    full: tuple[Town, list[PlacedPiece]],
) -> None:
    place, placed = full
    heights = []
    for thing in placed:
        if thing.piece.class_name == "building":
            low, high = thing.piece.bounds_m
            heights.append(high[2])
            inside = place.extent.x0 < low[0] and high[0] < place.extent.x1
            inside &= place.extent.y0 < low[1] and high[1] < place.extent.y1
            if inside:
                walls = np.concatenate([m.vertices_m for m, _ in thing.piece.parts])
                at_ground = walls[walls[:, 2] < 0.2]
                assert to_nearest_street_m(place, at_ground).min() >= CARRIAGEWAY_M / 2
    assert np.percentile(heights, 10) > 8
    assert max(heights) > 30


def test_everything_has_a_known_class(full: tuple[Town, list[PlacedPiece]]) -> None:
    classes = {thing.piece.class_name for thing in full[1]}
    assert classes <= set(CLASS_NAMES)
    assert {"road", "pavement", "building", "car", "tree", "footbridge", "lamp post", "sign"} <= classes


def test_kerbs_run_with_the_traffic_on_their_left() -> None:
    place = town(4)
    for kerb in kerbs(place):
        forward = np.array(((1, 0), (0, 1), (-1, 0), (0, -1))[kerb.heading])
        left = np.array([-forward[1], forward[0]])
        middle = np.array(kerb.start_m) + kerb.length_m / 2 * forward + CARRIAGEWAY_M / 2 * left
        assert to_nearest_street_m(place, middle[None])[0] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("body", BODIES)
def test_vehicles_stand_on_the_ground_and_have_their_size(body) -> None:
    low, high = car(body, draw_car(np.random.default_rng(0)).parts[0][1]).bounds_m
    assert low[2] == pytest.approx(0, abs=0.02)
    assert high[0] - low[0] == pytest.approx(body.length_m, abs=0.1)
    assert body.width_m <= high[1] - low[1] < body.width_m + 0.3
    assert 1.3 < high[2] < 2.6


def test_the_ground_faces_up_and_kerbs_face_the_road() -> None:
    block = town(2).inner_blocks()[0]
    for mesh, _ in pavement(block).parts:
        corners = mesh.vertices_m[mesh.triangles]
        facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert (np.einsum("ij,ij->i", facing, mesh.normals[mesh.triangles[:, 0]]) > 0).all()
        upright = np.abs(mesh.normals[:, 2]) < 0.5
        outwards = mesh.vertices_m[upright, :2] - np.array(block.centre)
        assert (np.einsum("ij,ij->i", outwards, mesh.normals[upright, :2]) > 0).all()
