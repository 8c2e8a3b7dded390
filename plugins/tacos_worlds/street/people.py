"""People on the pavements: some walk up and down them, some stand, some sit on benches."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Trajectory
from tacos_worlds.kit.people.person import draw_person
from tacos_worlds.kit.people.pose import standing, walking
from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.rectangle import Rect
from tacos_worlds.street.city import KERB_M, PAVEMENT_M, Kerb

SIDES = 6
"""Corners of a ring of a pedestrian's trunk: they are seen from across the street."""
PERSON_TRIANGLES = 580
"""No pedestrian has more."""
_HALF_M = 0.35
"""Half of the width a pedestrian needs [m]."""
_SPEED_M_S = (1.1, 1.55)
_TURN_S = 1e-3
"""To turn round in; a transform of the world would swing whoever turns slowly about its origin [s]."""
_SHORTEST_M = 8.0
_WALKING = 0.75
_TRIES = 12


@dataclass(frozen=True, eq=False)
class Pedestrian:
    piece: Piece  # the person where he or she rests
    trajectory: Trajectory | None  # from there to where the person is; None for those who stand


def draw_pedestrians(
    rng: np.random.Generator, kerbs: Sequence[Kerb], taken: Sequence[Rect], duration_s: float, count: int
) -> list[Pedestrian]:
    """Up to `count` people on the pavements behind some kerbs."""
    found: list[Pedestrian] = []
    ways: list[Rect] = []
    for stream in rng.spawn(count):
        kerb = kerbs[int(stream.integers(len(kerbs)))]
        walks = bool(stream.uniform() < _WALKING)
        for _ in range(_TRIES):
            start = float(stream.uniform(1.0, max(kerb.length_m - _SHORTEST_M - 2.0, 1.1)))
            reach = float(stream.uniform(_SHORTEST_M, 40.0)) if walks else 0.6
            end = min(start + reach, kerb.length_m - 1.0)
            left = -float(stream.uniform(0.5, PAVEMENT_M - 0.65))
            way = _swept(kerb, start, end, left)
            if end - start >= 0.5 and not any(way.overlaps(other) for other in (*taken, *ways)):
                ways.append(way)
                found.append(
                    _walker(stream, kerb, start, end, left, duration_s)
                    if walks
                    else _waiting(stream, kerb, start, left)
                )
                break
    return found


def _swept(kerb: Kerb, start_m: float, end_m: float, left_m: float) -> Rect:
    """The ground somebody needs between two places along a kerb."""
    a, b = kerb.point(start_m, left_m), kerb.point(end_m, left_m)
    return Rect(min(a[0], b[0]), min(a[1], b[1]), max(a[0], b[0]), max(a[1], b[1])).grown(_HALF_M)


def _waiting(rng: np.random.Generator, kerb: Kerb, along_m: float, left_m: float) -> Pedestrian:
    made = draw_person(rng, standing(rng), outdoors=True, sides=SIDES)
    x, y = kerb.point(along_m + 0.3, left_m)
    return Pedestrian(made.turned(float(rng.uniform(0, 2 * math.pi))).moved(x, y, KERB_M), None)


def _walker(
    rng: np.random.Generator, kerb: Kerb, start_m: float, end_m: float, left_m: float, duration_s: float
) -> Pedestrian:
    """Somebody who walks up and down between two places; rests half-way, for the light there."""
    made = draw_person(rng, walking(rng), outdoors=True, sides=SIDES)
    rest = np.array(kerb.point((start_m + end_m) / 2, left_m))
    heading = kerb.heading * math.pi / 2
    piece = made.turned(heading - math.pi / 2).moved(float(rest[0]), float(rest[1]), KERB_M)
    forward = np.array([math.cos(heading), math.sin(heading)])
    half, speed = (end_m - start_m) / 2, float(rng.uniform(*_SPEED_M_S))
    lap_s = 2 * half / speed
    first = -float(rng.uniform(0, 2 * lap_s))  # somewhere on the way when the drive begins
    times, poses = [], []
    for leg in range(int((duration_s - first) / lap_s) + 2):
        back = leg % 2 == 1
        begin = first + leg * lap_s
        for at_s, along in ((begin + _TURN_S / 2, -half), (begin + lap_s - _TURN_S / 2, half)):
            times.append(at_s)
            poses.append(_about(rest, rest + forward * (-along if back else along), math.pi * back))
    return Pedestrian(piece, Trajectory(np.array(times), np.array(poses)))


def _about(rest_m: NDArray[np.float64], to_m: NDArray[np.float64], yaw_rad: float) -> NDArray[np.float64]:
    """(4, 4) transform that turns about a place and takes it to another."""
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    pose = np.eye(4)
    pose[:2, :2] = [[cos, -sin], [sin, cos]]
    pose[:2, 3] = to_m - pose[:2, :2] @ rest_m
    return pose
