"""Poses of a body: the angles of its joints, and their places."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tacos_worlds.kit.mesh import Floats

ANKLE, KNEE, HIP, ELBOW, SHOULDER = 0.039, 0.285, 0.530, 0.630, 0.810
"""Heights of the joints of an upright body, as shares of its height.

References
----------
Drillis, R., and Contini, R. (1966). Body Segment Parameters. New York University, Technical Report 1166.03.
"""
FOREARM, HAND = 0.146, 0.090
_HIP_ASIDE, _SHOULDER_ASIDE = 0.047, 0.105
SEATED_THIGH = 0.045
"""Height of the hip above the seat it rests on, as a share of the body's height."""


@dataclass(frozen=True)
class Pose:
    """Angles of the joints, left and right, forward positive [deg]."""

    hips: tuple[float, float] = (0.0, 0.0)  # flexion [deg]
    knees: tuple[float, float] = (3.0, 3.0)  # flexion [deg]
    shoulders: tuple[float, float] = (3.0, 3.0)  # flexion [deg]
    elbows: tuple[float, float] = (12.0, 12.0)  # flexion [deg]
    arms_aside: float = 7.0  # how far the arms are held off the body [deg]
    lean: float = 0.0  # of the trunk, forward [deg]
    seated: bool = False  # true if the weight rests on a seat


@dataclass(frozen=True, eq=False)
class Joints:
    """Places of the joints around the middle of the hips, each (2, 3) for left and right but `hips` [m].

    x is to the right, y forward, z up; the lowest sole, or the seat, is at `ground_m`.
    """

    hip: Floats
    knee: Floats
    ankle: Floats
    shoulder: Floats
    elbow: Floats
    wrist: Floats
    fingers: Floats
    ground_m: float


def standing(rng: np.random.Generator) -> Pose:
    """At ease; some hold a phone, some rest a hand on the hip."""
    way = int(rng.integers(4))
    shift = float(rng.uniform(-4, 4))
    arms = {0: ((3.0, 3.0), (12.0, 18.0)), 1: ((22.0, 4.0), (105.0, 14.0)), 2: ((5.0, 25.0), (20.0, 95.0))}
    shoulders, elbows = arms.get(way, ((18.0, 20.0), (88.0, 92.0)))
    return Pose((shift, -shift), (4.0, 5.0), shoulders, elbows, float(rng.uniform(6, 11)), 1.0)


def walking(rng: np.random.Generator) -> Pose:
    phase = float(rng.uniform(0, 2 * math.pi))
    swing = math.sin(phase)
    hips = (24 * swing + 3, -24 * swing + 3)
    knees = tuple(6 + 38 * max(0.0, math.cos(phase + turn)) for turn in (0.0, math.pi))
    elbow = float(rng.uniform(15, 35))
    return Pose(hips, (knees[0], knees[1]), (-20 * swing, 20 * swing), (elbow, elbow), 6.0, 3.0)


def seated(rng: np.random.Generator, height_m: float, *, seat_m: float, back_deg: float) -> Pose:
    """On a seat, leaning back by so much, hands in the lap; the feet reach the floor, or dangle."""
    rise = (seat_m + SEATED_THIGH * height_m - KNEE * height_m) / ((HIP - KNEE) * height_m)
    thigh = math.degrees(math.acos(float(np.clip(rise, -0.35, 0.3))))
    bent = thigh + float(rng.uniform(-6, 6))
    hands = float(rng.uniform(58, 66))
    hips, knees = (thigh, thigh + 1), (bent, bent - 4)
    return Pose(hips, knees, (6.0, 8.0), (hands, hands + 4), 6.0, -back_deg, seated=True)


def joints_of(pose: Pose, height_m: float) -> Joints:
    h = height_m
    side = np.array([-1.0, 1.0])
    hip = np.column_stack([side * _HIP_ASIDE * h, np.zeros(2), np.zeros(2)])
    thigh, shank = np.radians(pose.hips), np.radians(np.subtract(pose.hips, pose.knees))
    knee = hip + (HIP - KNEE) * h * _hanging(thigh, 0.015 * side)
    ankle = knee + (KNEE - ANKLE) * h * _hanging(shank, 0.0 * side)
    top = rotated_forward(np.array([0.0, 0.0, (SHOULDER - HIP) * h]), pose.lean)
    shoulder = np.column_stack([side * _SHOULDER_ASIDE * h, np.zeros(2), np.zeros(2)]) + top
    aside = math.sin(math.radians(pose.arms_aside)) * side
    upper, lower = np.radians(pose.shoulders), np.radians(np.add(pose.shoulders, pose.elbows))
    elbow = shoulder + (SHOULDER - ELBOW) * h * _hanging(upper, aside)
    inwards = -0.35 * side * np.abs(np.sin(lower))
    wrist = elbow + FOREARM * h * _hanging(lower, inwards)
    fingers = wrist + HAND * h * _hanging(lower, 0.6 * inwards)
    ground = -SEATED_THIGH * h if pose.seated else float(ankle[:, 2].min()) - ANKLE * h
    return Joints(hip, knee, ankle, shoulder, elbow, wrist, fingers, ground)


def rotated_forward(points: Floats, angle_deg: float) -> Floats:
    """Points turned about x so that what is above moves forward [deg]."""
    cos, sin = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    return points @ np.array([[1.0, 0, 0], [0, cos, sin], [0, -sin, cos]]).T


def _hanging(forward_rad: Floats, aside: Floats) -> Floats:
    """(2, 3) unit vectors of two limbs that hang, swung forward and aside."""
    made = np.column_stack([aside, np.sin(forward_rad), -np.cos(forward_rad)])
    return made / np.linalg.norm(made, axis=1, keepdims=True)
