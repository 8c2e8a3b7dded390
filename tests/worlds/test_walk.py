"""The agent's trip: through doors, clear of things, smooth, over thresholds."""

from __future__ import annotations

from itertools import repeat

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from pydantic import ValidationError
from scipy import ndimage

from tacos_framework.errors import UserError
from tacos_framework.testing.samples import sample_episode
from tacos_framework.values import Episode
from tacos_worlds.indoor.building import Building
from tacos_worlds.indoor.scene import IndoorScene
from tacos_worlds.indoor.walk.band_loops import relax
from tacos_worlds.indoor.walk.free_space import CELL_M, CLEARANCE_M, FreeSpace
from tacos_worlds.indoor.walk.route import draw_route
from tacos_worlds.indoor.walk.walks import draw_walks
from tacos_worlds.kit.walk.motion import MAX_YAW_RATE_DEG_S, Walk, draw_walk
from tacos_worlds.kit.walk.route import Route
from tacos_worlds.kit.walk.trip import approaches, bursts, joined, spread

Routes = list[tuple[Building, FreeSpace, Route]]


@pytest.fixture(scope="module")
def routes(buildings: list[Building]) -> Routes:
    made = []
    for seed, building in enumerate(buildings):
        free = FreeSpace(building)
        made.append((building, free, draw_route(np.random.default_rng(seed), building, free)))
    return made


def _clearance_at(clearance_m: NDArray[np.float64], points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N,) distance to the nearest obstacle at (N, 2) points, between the middles of cells [m]."""
    return np.asarray(
        ndimage.map_coordinates(clearance_m, points_m.T / CELL_M - 0.5, order=1, mode="nearest")
    )


def test_a_route_visits_every_room(routes: Routes) -> None:
    for building, _, route in routes:
        plan = building.plan
        for room in range(len(plan.cells)):
            c = plan.clear(room).grown(-0.4)
            x, y = route.points_m.T
            assert np.any((x > c.x0) & (x < c.x1) & (y > c.y0) & (y < c.y1))


def test_a_route_stays_clear_of_walls_and_furniture(routes: Routes) -> None:
    for building, free, route in routes:
        assert _clearance_at(free.clearance_m, route.points_m).min() > 0.2
        x, y = route.points_m.T
        for m in building.furniture:
            if m.blocks:
                f = m.footprint
                assert not np.any((x > f.x0) & (x < f.x1) & (y > f.y0) & (y < f.y1))


def test_a_path_is_relaxed_to_the_bits_of_the_plain_formula() -> None:
    rng = np.random.default_rng(3)
    clearance_m = rng.uniform(0.2, 0.6, (40, 30))
    points_m = np.array([0.1, 2.8]) + np.cumsum(rng.normal(0, 0.06, (90, 2)), axis=0)  # some beyond the grid
    moves = rng.uniform(size=90) < 0.9
    moves[[0, -1]] = False
    reaches = np.repeat([50, 16, 3], 40)
    x_m, y_m = points_m.T.copy()
    relax(x_m, y_m, moves, reaches, clearance_m, CELL_M, CLEARANCE_M)
    relaxed = np.column_stack([x_m, y_m])
    plain = points_m.copy()
    for reach in reaches[reaches < 45].tolist():
        target = plain.copy()
        target[reach:-reach] = (plain[: -2 * reach] + plain[2 * reach :]) / 2
        target[1:-1] = 0.5 * target[1:-1] + 0.25 * (plain[:-2] + plain[2:])
        wanted = plain + 0.5 * (target - plain)
        allowed = moves & (_clearance_at(clearance_m, wanted) >= CLEARANCE_M)
        plain[allowed] = wanted[allowed]
    assert np.array_equal(relaxed, plain)
    assert 0 < np.count_nonzero((relaxed != points_m).any(axis=1)) < moves.sum()


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


BEFORE_S = (1.6, 1.4, 0.8, 0.6)


@pytest.fixture(scope="module")
def approached(buildings: list[Building]) -> tuple[Building, Episode]:
    """Nine approaches and a half; of the world behind them nothing is asked."""
    rng, building = np.random.default_rng(5), buildings[0]
    walks = draw_walks(rng, building, speed_m_s=1.0, camera_height_m=(0.0, 0.0))
    stretches = approaches(rng, walks, frames=38, before_s=BEFORE_S, camera_height_m=(1.0, 2.0))
    return building, joined(sample_episode(1).world, stretches)


def test_approaches_take_frames_at_the_times_before_their_crossing(
    approached: tuple[Building, Episode],
) -> None:
    _, episode = approached
    assert len(episode) == 38
    assert np.all(np.diff(episode.time_s) > 0)
    assert [crossing.walk for crossing in episode.crossings] == list(range(10))
    for number, crossing in enumerate(episode.crossings):
        before_s = crossing.time_s - episode.time_s[episode.walk == number]
        assert before_s == pytest.approx(BEFORE_S if number < 9 else BEFORE_S[2:])


def test_an_approach_ends_on_its_threshold_and_comes_from_afar(approached: tuple[Building, Episode]) -> None:
    building, episode = approached
    for number, crossing in enumerate(episode.crossings):
        door_m = building.plan.doors[crossing.object_id - 1].position_m
        step_m, path_m = (
            episode.trajectory.at(times)[:, :2, 3]
            for times in (np.array([crossing.time_s]), episode.time_s[episode.walk == number])
        )
        assert np.linalg.norm(step_m[0] - door_m) < 0.15
        distance_m = np.linalg.norm(path_m - door_m, axis=1)
        assert np.all(np.diff(distance_m) < 0)
        assert 0.3 < distance_m[-1] <= BEFORE_S[-1] * 1.35


def test_each_approach_has_an_eye_height_of_its_own(approached: tuple[Building, Episode]) -> None:
    _, episode = approached
    z = episode.trajectory.at(episode.time_s)[:, 2, 3]
    heights = np.array([z[episode.walk == number].mean() for number in range(10)])
    assert 0.95 < heights.min() < heights.max() < 2.05
    assert np.abs(np.diff(heights)).min() > 0.005
    assert max(np.ptp(z[episode.walk == number]) for number in range(10)) < 0.1


def test_the_agent_walks_while_the_shutter_of_an_approach_is_open(
    approached: tuple[Building, Episode],
) -> None:
    _, episode = approached
    half_s = 0.015
    opened, closed = (episode.trajectory.at(episode.time_s + side * half_s)[:, :2, 3] for side in (-1, 1))
    assert np.linalg.norm(closed - opened, axis=1).min() > 0.2 * 2 * half_s


def test_approaches_are_spread_over_the_thresholds(approached: tuple[Building, Episode]) -> None:
    building, episode = approached
    assert len({crossing.object_id for crossing in episode.crossings}) > len(building.plan.doors) / 2


def test_bursts_are_walks_of_their_own_spread_over_one(buildings: list[Building]) -> None:
    rng = np.random.default_rng(5)
    walk = next(draw_walks(rng, buildings[0], speed_m_s=1.0, camera_height_m=(1.5, 1.5)))
    taken = list(bursts(rng, iter([walk]), frames=11, burst_frames=3, frame_rate_hz=10.0))
    episode = joined(sample_episode(1).world, taken)
    assert np.bincount(episode.walk).tolist() == [3, 3, 3, 2]
    assert np.diff(episode.time_s[episode.walk == 1]) == pytest.approx([0.1, 0.1])
    assert np.diff([each.start_s for each in taken]) == pytest.approx((walk.duration_s - 0.2) / 4)
    assert taken[-1].end_s <= walk.duration_s
    for number, each in enumerate(taken):
        first = episode.trajectory.at(episode.time_s[episode.walk == number][:1])
        at = np.interp(each.start_s, walk.time_s, walk.world_from_agent[:, 0, 3])
        assert first[0, 0, 3] == pytest.approx(at, abs=1e-6)


def test_sampling_leaves_the_world_as_it_is() -> None:
    taken = [
        IndoorScene(IndoorScene.Config(size_m=(10, 5), frames=8, sampling=sampling)).episode(
            rng=np.random.default_rng(5), illumination_lux=20.0
        )
        for sampling in ("walk", "bursts", "approaches")
    ]
    assert [len(episode) for episode in taken] == [8, 8, 8]
    assert len({episode.world.key for episode in taken}) == 1
    assert [crossing.walk for crossing in taken[2].crossings] == [0, 1]


@given(count=st.integers(1, 9), passed=st.integers(1, 40), seed=st.integers(0, 99))
def test_a_few_of_many_crossings_are_evenly_apart(count: int, passed: int, seed: int) -> None:
    crossings = [(float(i), i) for i in range(passed)]
    picked = [i for _, i in spread(np.random.default_rng(seed), crossings, count)]
    assert len(picked) == min(count, passed)
    assert picked == sorted(set(picked))
    if len(picked) > 1:
        assert np.ptp(np.diff(picked)) <= 1


def test_approaches_without_a_threshold_are_refused() -> None:
    with pytest.raises(ValidationError, match="single room without thresholds"):
        IndoorScene.Config(size_m=(9, 9), sampling="approaches")
    with pytest.raises(ValidationError, match="must fall"):
        IndoorScene.Config(before_step_s=(0.6, 0.8))


def test_approaches_longer_than_any_walk_are_refused_with_a_way_out() -> None:
    short = Walk(np.array([0.0, 9.0]), np.tile(np.eye(4), (2, 1, 1)), ((4.0, 0),))
    stretches = approaches(
        np.random.default_rng(1), repeat(short), frames=4, before_s=(5.0, 0.5), camera_height_m=(1.0, 2.0)
    )
    with pytest.raises(UserError, match="as late as 5 s") as raised:
        next(stretches)
    assert "Give shorter ones" in str(raised.value)
