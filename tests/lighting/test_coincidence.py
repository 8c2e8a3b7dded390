"""The two sides of a sheet, found and lit apart."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tacos_framework import Material, MeshPart, Object, World
from tacos_plugins.coincident_faces import corners_behind, other_sides
from tacos_plugins.lighting import bake_indirect
from tacos_plugins.renderers.light.baked_mesh import light_world
from tacos_plugins.renderers.light.flatten import SurfaceKind

QUAD = np.array([[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0]], float)
TWO = np.array([[0, 1, 2], [0, 2, 3]])

places = st.tuples(*[st.floats(-50, 50)] * 3)
turns = st.tuples(*[st.floats(-3, 3)] * 3)


def sheet(place: tuple[float, ...], turn: tuple[float, ...]) -> np.ndarray:
    return (QUAD @ Rotation.from_rotvec(turn).as_matrix().T + place).astype(np.float32)


@given(place=places, turn=turns, shuffle=st.integers(0, 2))
def test_the_other_side_of_a_turned_sheet_is_found(place, turn, shuffle) -> None:
    points = sheet(place, turn)
    back = np.roll(TWO[:, ::-1], shuffle, axis=1)
    lonely = points[TWO] + np.float32(9)
    corners = np.concatenate([points[TWO], points[back], lonely])
    assert other_sides(corners).tolist() == [2, 3, 0, 1, -1, -1]


@given(place=places, turn=turns, gap_m=st.floats(-5e-5, 5e-5), seed=st.integers(0, 2**32 - 1))
def test_sides_apart_by_rounding_are_sides_of_one_sheet(place, turn, gap_m, seed) -> None:
    """As of a file whose sides were moved, or turned, one by one."""
    points = sheet(place, turn).astype(float)
    normal = np.cross(points[1] - points[0], points[2] - points[0])
    away = np.random.default_rng(seed).uniform(-1e-5, 1e-5, points.shape)
    back = points + gap_m * normal / np.linalg.norm(normal) + away
    corners = np.concatenate([points[TWO], back[TWO[:, ::-1]]]).astype(np.float32)
    assert other_sides(corners).tolist() == [2, 3, 0, 1]


@given(place=places, turn=turns, gap_m=st.floats(1e-3, 0.05))
def test_sides_of_a_thin_board_are_not(place, turn, gap_m) -> None:
    points = sheet(place, turn).astype(float)
    normal = np.cross(points[1] - points[0], points[2] - points[0])
    back = points + gap_m * normal / np.linalg.norm(normal)
    assert set(other_sides(np.concatenate([points[TWO], back[TWO[:, ::-1]]]))) == {-1}


def test_corners_of_the_other_side_lie_at_the_same_places() -> None:
    points = np.concatenate([sheet((1, 2, 3), (0.3, 0, 1))] * 2)
    triangles = np.concatenate([TWO, 4 + np.roll(TWO[:, ::-1], 1, axis=1)])
    behind = corners_behind(points, triangles, other_sides(points[triangles]))
    np.testing.assert_array_equal(points[behind], points[triangles])
    assert (behind // 4 != triangles // 4).all()


def test_triangles_of_no_extent_and_equal_ones_are_no_sides() -> None:
    flat = np.array([[[0, 0, 0], [1, 0, 0], [1, 0, 0]]], np.float32)
    assert other_sides(np.concatenate([flat, flat])).tolist() == [-1, -1]
    assert other_sides(np.zeros((0, 3, 3))).tolist() == []


OTHERWISE = np.array([[0, 1, 3], [1, 2, 3]])
"""The same quad, cut along its other diagonal."""


@given(place=places, turn=turns)
def test_a_side_cut_along_the_other_diagonal_is_the_other_side(place, turn) -> None:
    points = sheet(place, turn)
    lonely = points[TWO] + np.float32(9)
    found = other_sides(np.concatenate([points[TWO], points[OTHERWISE[:, ::-1]], lonely]))
    assert set(found[:2]) <= {2, 3}
    assert set(found[2:4]) <= {0, 1}
    assert found[4:].tolist() == [-1, -1]
    assert set(other_sides(np.concatenate([points[TWO], points[OTHERWISE]]))) == {-1}  # one upon the other


@given(place=places, turn=turns, cuts=st.integers(2, 5))
def test_a_side_cut_finer_is_the_other_side(place, turn, cuts) -> None:
    steps = np.linspace(0, 1, cuts + 1)
    finer = [
        QUAD[[0, 1, 2]] * [1, 0, 1] + np.array([[0, 2 * a, 0], [0, 2 * a, 0], [0, 2 * b, 0]])
        for a, b in pairwise(steps)
    ]
    finer += [np.array([[0, 2 * a, 0], [1, 2 * b, 0], [0, 2 * b, 0]]) for a, b in pairwise(steps)]
    move = Rotation.from_rotvec(turn).as_matrix().T
    corners = np.concatenate([QUAD[TWO], np.stack(finer)[:, ::-1]]) @ move + place
    assert (other_sides(corners.astype(np.float32)) >= 0).all()


@given(place=places, turn=turns, share=st.floats(0.1, 0.8))
def test_what_stands_on_a_floor_is_no_side_of_it(place, turn, share) -> None:
    points = sheet(place, turn)
    foot = points.mean(axis=0) + np.float32(share) * (points - points.mean(axis=0))
    assert set(other_sides(np.concatenate([points[TWO], foot[TWO[:, ::-1]]]))) == {-1}


@pytest.mark.parametrize("back", [TWO, OTHERWISE])
@settings(max_examples=20, deadline=None)
@given(place=places, turn=turns)
def test_every_side_of_a_random_double_sheet_is_drawn_from_its_own_side_alone(back, place, turn) -> None:
    points = sheet(place, turn)
    normal = np.cross(points[1] - points[0], points[2] - points[0])
    normals = np.tile(normal / np.linalg.norm(normal), (4, 1))
    part = MeshPart(
        np.concatenate([points, points]),
        np.concatenate([normals, -normals]).astype(np.float32),
        np.zeros((8, 2), np.float32),
        np.concatenate([TWO, back[:, ::-1] + 4]).astype(np.int32),
        material=0,
        object_id=0,
    )
    world = World("w", (part,), (Material("m", np.ones(3, np.float32)),), (Object("b", "b"),), ("b",))
    baked = light_world(world, bake_indirect(world), 0.1)
    assert (baked.chunks.kind & SurfaceKind.CLOSED).all()


@given(seed=st.integers(0, 2**32 - 1))
def test_planes_a_rounding_apart_do_not_trip_it(seed) -> None:
    rng = np.random.default_rng(seed)
    level = rng.choice([0, 1e-4, 2e-4, 3e-4, 1.0], (40, 1, 1)) * [0, 0, 1]
    corners = rng.uniform(-1, 1, (40, 3, 3)) * [1, 1, rng.choice([0, 1e-5, 1e-3])] + level
    other = other_sides(corners)
    assert ((other >= -1) & (other < 40)).all()
