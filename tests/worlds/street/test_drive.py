"""The way of the car, and of the others: on the road, at a car's pace, out of each other's way."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_framework.values import Trajectory
from tacos_worlds.street.city import CARRIAGEWAY_M, CORNER_M, LANE_M, Town, draw_town
from tacos_worlds.street.drive import (
    BRAKING_M_S2,
    FORWARD_M_S2,
    LATERAL_M_S2,
    draw_way,
    drive,
)
from tacos_worlds.street.traffic import draw_traffic

SPEED = 11.0


def town(seed: int, blocks: int = 3) -> Town:
    return draw_town(np.random.default_rng(seed), blocks=blocks, reach_m=120.0)


def driven(seed: int, length_m: float = 800.0) -> tuple[Town, Trajectory]:
    place = town(seed)
    return place, drive(draw_way(np.random.default_rng(seed), place, length_m), SPEED, 2.0)


def on_the_road(place: Town, points: np.ndarray, margin_m: float) -> np.ndarray:
    x = np.abs(points[:, :1] - np.array(place.street_x_m)).min(axis=1)
    y = np.abs(points[:, 1:2] - np.array(place.street_y_m)).min(axis=1)
    half = CARRIAGEWAY_M / 2
    on_a_street = np.minimum(x, y) < half - margin_m
    # Within a rounded corner: nearer to both streets than the arc allows.
    reach = half + CORNER_M
    in_corner = (x < reach) & (y < reach) & (np.hypot(reach - x, reach - y) > CORNER_M + margin_m)
    return on_a_street | in_corner


@given(st.integers(0, 1000))
@settings(max_examples=15, deadline=None)
def test_the_car_stays_on_the_road_and_drives_like_one(seed: int) -> None:
    place, way = driven(seed)
    points = way.world_from_agent[:, :2, 3]
    assert on_the_road(place, points, 1.0).all()
    inner = place.middle.grown(CARRIAGEWAY_M)
    assert (points >= [inner.x0, inner.y0]).all()
    assert (points <= [inner.x1, inner.y1]).all()

    step_s = np.diff(way.time_s)[:, None]
    velocity = np.diff(points, axis=0) / step_s
    speed = np.linalg.norm(velocity, axis=1)
    assert speed.max() < SPEED + 0.1
    assert speed.min() > 2.0
    along = np.diff(speed) / step_s[1:, 0]
    assert along.max() < FORWARD_M_S2 + 0.5
    assert along.min() > -BRAKING_M_S2 - 0.5
    forward = way.world_from_agent[:-1, :2, 0]
    assert (np.einsum("ij,ij->i", forward, velocity) > 0.98 * speed).all()
    yaw = np.unwrap(np.arctan2(way.world_from_agent[:, 1, 0], way.world_from_agent[:, 0, 0]))
    sideways = np.abs(np.diff(yaw) / step_s[:, 0]) * speed
    assert sideways.max() < 1.3 * LATERAL_M_S2


def test_it_turns_both_ways_and_goes_straight_on() -> None:
    _, way = driven(2, 4000.0)
    yaw = np.unwrap(np.arctan2(way.world_from_agent[:, 1, 0], way.world_from_agent[:, 0, 0]))
    turned = np.diff(yaw)
    assert turned.max() > 0.005
    assert turned.min() < -0.005
    assert np.mean(np.abs(turned) < 1e-4) > 0.5


def test_it_keeps_to_the_right() -> None:
    place, way = driven(6)
    forward, points = way.world_from_agent[:, :2, 0], way.world_from_agent[:, :2, 3]
    straight = np.abs(forward).max(axis=1) > 0.9999
    far_from_crossings = np.ones(len(points), dtype=bool)
    for x in place.street_x_m:
        for y in place.street_y_m:
            far_from_crossings &= np.linalg.norm(points - [x, y], axis=1) > 20
    for k in np.flatnonzero(straight & far_from_crossings)[::50]:
        lines = place.street_y_m if abs(forward[k, 0]) > 0.5 else place.street_x_m
        axis = 1 if abs(forward[k, 0]) > 0.5 else 0
        line = min(lines, key=lambda at: abs(at - points[k, axis]))
        right = np.array([forward[k, 1], -forward[k, 0]])
        assert (points[k, axis] - line) * right[axis] == pytest.approx(LANE_M / 2, abs=0.05)


@pytest.mark.parametrize("seed", [0, 1])
def test_no_two_cars_ever_meet(seed: int) -> None:
    place, agent = driven(seed)
    drivers = draw_traffic(np.random.default_rng(seed), place, agent, 60.0, 10)
    assert len(drivers) == 10
    time_s = np.arange(0, 60, 0.05)
    ways = [agent.at(time_s)[:, :2, 3]]
    for driver in drivers:
        low, high = driver.piece.bounds_m
        middle = (low + high)[:2] / 2
        ways.append(middle + driver.trajectory.at(time_s)[:, :2, 3])
    for number, first in enumerate(ways):
        for second in ways[number + 1 :]:
            assert np.linalg.norm(first - second, axis=1).min() > 2.5
    moving = [np.ptp(way, axis=0).max() > 50 for way in ways]
    assert sum(moving) > len(ways) / 2


def test_other_cars_keep_to_straight_lines_at_one_speed() -> None:
    place, agent = driven(3)
    for driver in draw_traffic(np.random.default_rng(1), place, agent, 30.0, 4):
        poses = driver.trajectory.world_from_agent
        assert np.allclose(poses[:, :3, :3], np.eye(3))
        speed = np.linalg.norm(np.diff(poses[:, :2, 3], axis=0), axis=1) / np.diff(driver.trajectory.time_s)
        cruising = speed[(speed > 0) & (speed < 100)]
        assert cruising.min() > 7.9
        assert cruising.max() < 12.1
