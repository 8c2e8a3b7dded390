"""Markers hung in a box-shaped room."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tacos_framework.errors import UserError
from tacos_framework.testing.samples import sample_episode
from tacos_framework.values import Episode, MeshPart, Trajectory
from tacos_plugins.tasks.fiducials.families import tags_of
from tacos_worlds.tags.place_tags import PlaceTags

HALF_M = 4.5


def room() -> Episode:
    """Four walls of 9 x 3 m around the agent."""
    episode = sample_episode(4)
    parts = []
    for turn in range(4):
        c, s = np.cos(turn * np.pi / 2), np.sin(turn * np.pi / 2)
        wall = np.array(
            [[HALF_M, -HALF_M, 0], [HALF_M, HALF_M, 0], [HALF_M, HALF_M, 3], [HALF_M, -HALF_M, 3]]
        )
        about = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        parts.append(
            MeshPart(
                (wall @ about.T).astype(np.float32),
                np.tile(about @ (-1.0, 0, 0), (4, 1)).astype(np.float32),
                np.zeros((4, 2), np.float32),
                np.array([[0, 2, 1], [0, 3, 2]], np.int32),
                0,
                0,
            )
        )
    return replace(episode, world=replace(episode.world, parts=tuple(parts), indirect_lux=None))


def hung(episode: Episode, **config) -> Episode:
    return PlaceTags(PlaceTags.Config(**config)).transform(episode, memory={})


def test_markers_hang_flat_on_walls_facing_the_room():
    tags = list(tags_of(hung(room(), count=6).world))
    assert [tag.number for tag in tags] == list(range(6))
    for tag in tags:
        middle = tag.corners_m.mean(axis=0)
        axis = int(np.abs(middle[:2]).argmax())
        assert HALF_M - abs(middle[axis]) == pytest.approx(0.002, abs=1e-3)
        assert np.ptp(tag.corners_m[:, axis]) < 1e-5
        assert tag.edge_m == pytest.approx(0.16, rel=1e-5)
        normal = np.cross(tag.corners_m[3] - tag.corners_m[0], tag.corners_m[1] - tag.corners_m[0])
        assert normal @ middle < 0  # towards the room
        assert tag.corners_m[0, 2] > tag.corners_m[3, 2]  # its top is up


def test_markers_do_not_overlap():
    middles = np.array([tag.corners_m.mean(axis=0) for tag in tags_of(hung(room(), count=20).world)])
    apart = np.linalg.norm(middles[:, None] - middles, axis=-1) + np.eye(len(middles))
    assert apart.min() > 0.2


def test_equal_seeds_hang_them_alike_and_others_do_not():
    one, same, other = (hung(room(), count=3, seed=seed) for seed in (1, 1, 2))
    places = [[tag.corners_m.tolist() for tag in tags_of(each.world)] for each in (one, same, other)]
    assert places[0] == places[1] != places[2]
    assert one.world.key == same.world.key != other.world.key


def test_worlds_with_other_places_have_other_keys():
    episode = room()
    poses = episode.trajectory.world_from_agent.copy()
    poses[:, 1, 3] += 1.0
    elsewhere = replace(episode, trajectory=Trajectory(episode.trajectory.time_s, poses))
    assert hung(episode, count=3).world.key != hung(elsewhere, count=3).world.key


def test_batches_share_one_world():
    episode, memory = room(), {}
    transform = PlaceTags(PlaceTags.Config(count=3))
    first, second = (transform.transform(episode[part], memory=memory) for part in (slice(0, 2), slice(2, 4)))
    assert first.world is second.world


def test_a_world_without_a_wall_is_refused_with_what_to_do():
    episode = room()
    wall = episode.world.parts[0]
    floor = replace(wall, vertices_m=(wall.vertices_m[:, [1, 2, 0]] - (0, 0, 9)).astype(np.float32))
    with pytest.raises(UserError, match="no wall of this world takes a marker"):
        hung(replace(episode, world=replace(episode.world, parts=(floor,))))
