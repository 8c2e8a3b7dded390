"""The agent's trip: through doors, clear of things, smooth, over thresholds."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_framework.values import Episode
from tacos_worlds.indoor.building import Building
from tacos_worlds.indoor.scene import IndoorScene
from tacos_worlds.indoor.walk.free_space import FreeSpace
from tacos_worlds.indoor.walk.motion import MAX_YAW_RATE_DEG_S, draw_walk
from tacos_worlds.indoor.walk.route import Route, draw_route

Routes = list[tuple[Building, FreeSpace, Route]]


@pytest.fixture(scope="module")
def routes(buildings: list[Building]) -> Routes:
    made = []
    for seed, building in enumerate(buildings):
        free = FreeSpace(building)
        made.append((building, free, draw_route(np.random.default_rng(seed), building, free)))
    return made


def test_a_route_visits_every_room(routes: Routes) -> None:
    for building, _, route in routes:
        plan = building.plan
        for room in range(len(plan.cells)):
            c = plan.clear(room).grown(-0.4)
            x, y = route.points_m.T
            assert np.any((x > c.x0) & (x < c.x1) & (y > c.y0) & (y < c.y1))


def test_a_route_stays_clear_of_walls_and_furniture(routes: Routes) -> None:
    for building, free, route in routes:
        assert free.clearance_at(route.points_m).min() > 0.2
        x, y = route.points_m.T
        for m in building.furniture:
            if m.blocks:
                f = m.footprint
                assert not np.any((x > f.x0) & (x < f.x1) & (y > f.y0) & (y < f.y1))


def test_a_route_crosses_doors_through_the_middle(routes: Routes) -> None:
    for building, _, route in routes:
        assert len(route.door_at) >= len(building.plan.cells) - 1
        for point, door in route.door_at:
            offset = route.points_m[point] - building.plan.doors[door].position_m
            assert np.linalg.norm(offset) < 0.12


def test_steps_of_a_route_are_even_and_bends_are_round(
    routes: Routes,
) -> None:
    for _, _, route in routes:
        assert np.linalg.norm(np.diff(route.points_m, axis=0), axis=1).max() < 0.08


def test_the_head_turns_no_faster_than_people_do(routes: Routes) -> None:
    for seed, (_, _, route) in enumerate(routes):
        walk = draw_walk(np.random.default_rng(seed), route, speed_m_s=1.0, camera_height_m=1.6)
        forward = walk.world_from_agent[:, :3, 0]
        yaw = np.unwrap(np.arctan2(forward[:, 1], forward[:, 0]))
        rate = np.degrees(np.abs(np.diff(yaw) / np.diff(walk.time_s)))
        assert rate.max() < 2 * MAX_YAW_RATE_DEG_S  # glances add to bends
        assert np.quantile(rate, 0.95) < 1.3 * MAX_YAW_RATE_DEG_S
        speed = np.linalg.norm(np.diff(walk.world_from_agent[:, :2, 3], axis=0), axis=1) / np.diff(
            walk.time_s
        )
        assert speed.max() < 1.35
        assert np.abs(forward[:, 2]).max() < np.sin(np.radians(6))


def test_the_head_looks_where_the_agent_walks(routes: Routes) -> None:
    _, _, route = routes[0]
    walk = draw_walk(np.random.default_rng(0), route, speed_m_s=1.0, camera_height_m=1.6)
    step = np.diff(walk.world_from_agent[:, :2, 3], axis=0)
    moving = np.linalg.norm(step, axis=1) > 0.02
    forward = walk.world_from_agent[:-1, :2, 0]
    along = np.einsum("ij,ij->i", step, forward)[moving] / np.linalg.norm(step[moving], axis=1)
    assert np.median(along) > 0.97


def test_an_episode_has_its_frames_at_its_rate(episode: Episode) -> None:
    assert len(episode) == 500
    for number in np.unique(episode.walk):
        times = episode.time_s[episode.walk == number]
        assert np.diff(times) == pytest.approx(np.full(len(times) - 1, 0.2))


def test_eyes_keep_their_height_within_a_walk(episode: Episode) -> None:
    poses = episode.trajectory.at(episode.time_s)
    for number in np.unique(episode.walk):
        z = poses[episode.walk == number, 2, 3]
        assert 0.95 < z.min() < z.max() < 2.05
        assert np.ptp(z) < 0.1


def test_crossings_are_where_and_when_a_threshold_is_stepped_on(episode: Episode) -> None:
    assert episode.crossings
    poses = episode.trajectory.at(np.array([c.time_s for c in episode.crossings]))
    for crossing, pose in zip(episode.crossings, poses, strict=True):
        assert episode.world.objects[crossing.object_id].class_name == "threshold"
        parts = [p.vertices_m for p in episode.world.parts if p.object_id == crossing.object_id]
        low, high = np.concatenate(parts).min(axis=0)[:2], np.concatenate(parts).max(axis=0)[:2]
        assert np.all(pose[:2, 3] > low - 0.05)
        assert np.all(pose[:2, 3] < high + 0.05)
        nearest = np.abs(episode.time_s - crossing.time_s).min()
        assert nearest <= 0.1 + 1e-9


def test_every_threshold_walked_over_is_listed(episode: Episode) -> None:
    world = episode.world
    times = np.arange(episode.time_s[0], episode.time_s[-1], 0.05)
    near_frame = np.abs(times[:, None] - episode.time_s[None, :]).min(axis=1) <= 0.1 + 1e-9
    feet = episode.trajectory.at(times[near_frame])[:, :2, 3]
    listed = {crossing.object_id for crossing in episode.crossings}
    for number, thing in enumerate(world.objects):
        if thing.class_name == "threshold":
            corners = np.concatenate([p.vertices_m[:, :2] for p in world.parts if p.object_id == number])
            middle = corners.mean(axis=0)
            if np.linalg.norm(feet - middle, axis=1).min() < 0.05:
                assert number in listed


def test_few_frames_still_cross_a_threshold() -> None:
    config = IndoorScene.Config(size_m=(10, 5), frames=30, frame_rate_hz=5.0)
    for seed in range(3):
        few = IndoorScene(config).episode(rng=np.random.default_rng(seed), illumination_lux=5.0)
        assert len(few) == 30
        assert few.crossings


def test_a_single_room_is_walked_without_crossings() -> None:
    config = IndoorScene.Config(size_m=(5, 5), frames=20)
    alone = IndoorScene(config).episode(rng=np.random.default_rng(1), illumination_lux=5.0)
    assert len(alone) == 20
    assert alone.crossings == ()
    eyes = alone.trajectory.at(alone.time_s)[:, :2, 3]
    assert np.ptp(eyes, axis=0).max() > 0.3
    assert eyes.min() > 0.2
    assert eyes.max() < 4.8
