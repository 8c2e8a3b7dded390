"""Other cars that drive along the streets while the car with the cameras does."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Trajectory
from tacos_worlds.kit.mesh import Mesh
from tacos_worlds.kit.piece import Piece
from tacos_worlds.street.city import LANE_M, Town
from tacos_worlds.street.finishes import TYRE
from tacos_worlds.street.night import with_lamps_on
from tacos_worlds.street.panels import ground
from tacos_worlds.street.things.vehicles import draw_car

_STEP_S = 0.2
_LENGTH_M, _WIDTH_M = 8.0, 2.9
"""Two cars whose middles come closer than both, along and across one of them, are too close [m]."""
_SPEED_M_S = (8.0, 12.0)
_WAIT_S = 2.0
_PAUSE_S = 6.0
_JUMP_S = 1e-3
_MARGIN_M = 6.0

Line = tuple[NDArray[np.float64], NDArray[np.float64]]
"""(N, 2) places [m] and (N, 2) directions of a car over time."""


@dataclass(frozen=True, eq=False)
class Driver:
    """A car that drives along one street again and again."""

    piece: Piece  # the car where it rests: at the beginning of its lane
    trajectory: Trajectory  # from there to where it is


def draw_traffic(
    rng: np.random.Generator,
    town: Town,
    agent: Trajectory,
    duration_s: float,
    count: int,
    *,
    lamps: bool = False,
) -> list[Driver]:
    """Up to `count` cars that come too close neither to each other nor to the agent.

    Each waits at the beginning of its lane until the whole way through the town is free for it, drives to the
    end, and begins anew. With `lamps` their lights are on.
    """
    lanes = _lanes(town)
    chosen = rng.permutation(len(lanes))[:count]
    clock_s = np.arange(-_MARGIN_M, duration_s + _MARGIN_M, _STEP_S)
    poses = agent.at(clock_s)
    taken: list[Line] = [(poses[:, :2, 3], poses[:, :2, 0])]
    drivers = []
    for lane, stream in zip(chosen.tolist(), rng.spawn(len(chosen)), strict=True):
        start, direction, length = lanes[lane]
        speed = float(stream.uniform(*_SPEED_M_S))
        travelled = _schedule(stream, clock_s, taken, start, direction, length, speed)
        places = start + travelled[:, None] * direction
        taken.append((places, np.broadcast_to(direction, places.shape)))
        yaw = math.atan2(direction[1], direction[0])
        car = with_lamps_on(draw_car(stream)) if lamps else draw_car(stream)
        piece = Piece("car", (*car.parts, (_shade(car), TYRE))).turned(yaw).moved(*start.tolist())
        drivers.append(Driver(piece, _moved(clock_s, travelled, direction)))
    return drivers


def _lanes(town: Town) -> list[tuple[NDArray[np.float64], NDArray[np.float64], float]]:
    """Beginning, direction and length of every lane."""
    extent, side = town.extent, LANE_M / 2
    lanes = []
    for y in town.street_y_m:
        length = extent.x1 - extent.x0 - 2 * _MARGIN_M
        lanes.append((np.array([extent.x0 + _MARGIN_M, y - side]), np.array([1.0, 0.0]), length))
        lanes.append((np.array([extent.x1 - _MARGIN_M, y + side]), np.array([-1.0, 0.0]), length))
    for x in town.street_x_m:
        length = extent.y1 - extent.y0 - 2 * _MARGIN_M
        lanes.append((np.array([x + side, extent.y0 + _MARGIN_M]), np.array([0.0, 1.0]), length))
        lanes.append((np.array([x - side, extent.y1 - _MARGIN_M]), np.array([0.0, -1.0]), length))
    return lanes


def _schedule(
    rng: np.random.Generator,
    clock_s: NDArray[np.float64],
    taken: list[Line],
    start: NDArray[np.float64],
    direction: NDArray[np.float64],
    length_m: float,
    speed_m_s: float,
) -> NDArray[np.float64]:
    """(N,) how far along its lane a car is at each moment, 0 while it waits [m]."""
    travelled = np.zeros(len(clock_s))
    lasts = int(length_m / speed_m_s / _STEP_S)
    at = -int(rng.uniform(0.1, 0.9) * lasts)  # on its way when the drive begins
    while at < len(clock_s):
        moments = np.arange(max(at, 0), min(at + lasts, len(clock_s)))
        way = (moments - at) * _STEP_S * speed_m_s
        places = start + way[:, None] * direction
        if any(_too_close(places, direction, where[moments], facing[moments]) for where, facing in taken):
            at += int(_WAIT_S / _STEP_S)
            continue
        travelled[moments] = way
        at += lasts + int(rng.exponential(_PAUSE_S) / _STEP_S) + 1
    return travelled


def _too_close(
    places: NDArray[np.float64],
    direction: NDArray[np.float64],
    others: NDArray[np.float64],
    facing: NDArray[np.float64],
) -> bool:
    """True if two cars ever meet."""
    apart = others - places

    def within(heading: NDArray[np.float64]) -> NDArray[np.bool_]:
        along = np.abs((apart * heading).sum(axis=1))
        across = np.abs(apart[:, 0] * heading[..., 1] - apart[:, 1] * heading[..., 0])
        return np.asarray((along < _LENGTH_M) & (across < _WIDTH_M))

    return bool((within(direction) | within(facing)).any())


def _moved(
    clock_s: NDArray[np.float64], travelled_m: NDArray[np.float64], direction: NDArray[np.float64]
) -> Trajectory:
    """The way of a car; from the end of its lane to the beginning it jumps."""
    jumps = np.flatnonzero(np.diff(travelled_m) < 0)
    time_s = np.concatenate([clock_s, clock_s[jumps] + _JUMP_S])
    travelled = np.concatenate([travelled_m, travelled_m[jumps + 1]])
    order = np.argsort(time_s, kind="stable")
    poses = np.tile(np.eye(4), (len(time_s), 1, 1))
    poses[:, :2, 3] = travelled[order, None] * direction
    return Trajectory(time_s[order], poses)


def _shade(car: Piece) -> Mesh:
    """The dark underneath a car, which stands for the shadow that nothing that moves casts."""
    low, high = car.bounds_m
    return ground((low[0] + 0.15, high[0] - 0.15), (low[1] + 0.2, high[1] - 0.2), 0.03)
