"""A person as a `Piece`: facing +y, standing on z = 0, or sitting with the seat at z = 0."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tacos_worlds.kit.finishes import Finish
from tacos_worlds.kit.mesh import Floats, Mesh, merged, shaded
from tacos_worlds.kit.people.clothes import Clothes, draw_clothes
from tacos_worlds.kit.people.pose import HIP, Joints, Pose, joints_of, rotated_forward
from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.shapes import loft, slab, superellipse, tube

Rings = tuple[tuple[float, float, float, float], ...]
"""(height, half width, half depth, middle forward) of each ring, in shares of the body's height."""

_SMOOTH_DEG = 75.0
_TRUNK: Rings = (
    (0.545, 0.101, 0.075, 0.0),
    (0.62, 0.083, 0.062, 0.0),
    (0.72, 0.100, 0.069, 0.004),
    (0.785, 0.112, 0.061, 0.0),
    (0.822, 0.090, 0.048, -0.004),
    (0.850, 0.036, 0.036, 0.0),
)
_COAT: Rings = ((0.40, 0.112, 0.086, 0.0), (0.53, 0.104, 0.078, 0.0), *_TRUNK[1:])
_HIPS: Rings = (
    (0.455, 0.060, 0.048, 0.0),
    (0.49, 0.094, 0.066, 0.0),
    (0.53, 0.097, 0.070, -0.004),
    (0.585, 0.076, 0.056, 0.0),
)
_SKIRT: Rings = ((0.29, 0.130, 0.105, 0.0), (0.45, 0.106, 0.082, 0.0), *_HIPS[2:])
_HEAD: Rings = (
    (0.866, 0.014, 0.018, 0.020),
    (0.880, 0.030, 0.038, 0.010),
    (0.910, 0.041, 0.051, 0.004),
    (0.948, 0.044, 0.056, 0.0),
    (0.982, 0.034, 0.044, -0.002),
    (1.000, 0.010, 0.014, -0.004),
)
_HAIR: Rings = (
    (0.895, 0.036, 0.030, -0.030),
    (0.925, 0.045, 0.042, -0.020),
    (0.958, 0.048, 0.056, -0.006),
    (0.990, 0.038, 0.048, -0.004),
    (1.008, 0.012, 0.016, -0.006),
)
_LONG_HAIR: Rings = ((0.80, 0.040, 0.016, -0.062), (0.86, 0.046, 0.024, -0.046), *_HAIR[1:])
_CHIN = 0.866
_LEAST_HEAD_M = 0.2
"""Heads of children are as large as this [m]."""


@dataclass(frozen=True)
class Build:
    height_m: float  # upright, without shoes [m]
    girth: float  # over that of a slim body of the same height [1]
    sides: int  # corners of a ring of the trunk: how smooth it is drawn

    @property
    def near(self) -> bool:
        """True if it is drawn with eyes, and knees that bend round."""
        return self.sides >= 8

    @property
    def limb_sides(self) -> int:
        """Corners of a ring of a limb."""
        return max(5, self.sides - 2)


def draw_build(rng: np.random.Generator, *, sides: int) -> Build:
    """An adult, or one time in eight a child."""
    child = rng.uniform() < 0.125
    height = rng.uniform(1.1, 1.45) if child else np.clip(rng.normal(1.71, 0.09), 1.5, 1.95)
    return Build(float(height), float(np.clip(rng.normal(1.08, 0.1), 0.92, 1.35)), sides)


def draw_person(
    rng: np.random.Generator, pose: Pose, *, outdoors: bool = False, cloth: str = "", sides: int = 10
) -> Piece:
    """A random person in a pose, in clothes of a texture (see `draw_clothes`)."""
    return person(draw_build(rng, sides=sides), pose, draw_clothes(rng, outdoors=outdoors, cloth=cloth))


def person(build: Build, pose: Pose, clothes: Clothes) -> Piece:
    at = joints_of(pose, build.height_m)
    skirt = clothes.skirt and not pose.seated
    trunk = _COAT if clothes.coat and not pose.seated else _TRUNK
    skin = [*_head(build, pose), *_hands(build, at)]
    legs = _legs(build, at)
    top = [_rings(build, trunk, pose.lean)]
    sleeves, forearms = _arms(build, at)
    top += sleeves
    (skin if clothes.short_sleeves else top).extend(forearms)
    hips = [_rings(build, _SKIRT if skirt else _HIPS, 0.0)]
    (skin if skirt else hips).extend(legs)
    hair = _rings(build, _LONG_HAIR if clothes.long_hair else _HAIR, pose.lean, head=True)
    parts = [
        (merged(skin), clothes.skin),
        (merged(top), clothes.top),
        (merged(hips), clothes.trousers),
        (merged(_shoes(build, at, pose)), clothes.shoes),
        (hair, clothes.hair),
    ]
    if build.near:
        parts.append((merged(_eyes(build, pose)), Finish("", (0.02, 0.017, 0.015), roughness=0.85)))
    made = Piece("person", tuple(parts))
    # On its feet a body rests on whatever is lowest of its soles: a toe, in the middle of a step.
    ground = at.ground_m if pose.seated else float(made.bounds_m[0][2])
    return made.moved(0, 0, -ground)


def _rings(build: Build, rings: Rings, lean_deg: float, *, head: bool = False) -> Mesh:
    """A closed surface through rings, which leans about the hips."""
    h, girth = build.height_m, 1.0 if head else build.girth
    made: list[Floats] = []
    for height, wide, deep, ahead in rings:
        ring = superellipse(wide * girth * h, deep * girth * h, height * h, power=2.4, sides=build.sides)
        made.append(ring + np.array([0, ahead * h, 0]))
    if head:
        made = [_grown_head(build, ring) for ring in made]
    down = np.array([0, 0, HIP * h])
    return loft([rotated_forward(ring - down, lean_deg) for ring in made], crease_deg=_SMOOTH_DEG)


def _grown_head(build: Build, points: Floats) -> Floats:
    """Points of a head made as large as heads are at least, from the chin upwards."""
    h = build.height_m
    chin = np.array([0, 0, _CHIN * h])
    return chin + (points - chin) * max(1.0, _LEAST_HEAD_M / ((1 - _CHIN) * h))


def _head(build: Build, pose: Pose) -> list[Mesh]:
    h = build.height_m
    neck = np.array([[0, -0.004, 0.835], [0, 0.0, 0.885]]) * h
    nose = np.array([[0, 0.048, 0.938], [0, 0.070, 0.908], [-0.010, 0.046, 0.903], [0.010, 0.046, 0.903]]) * h
    down = np.array([0, 0, HIP * h])
    nose = rotated_forward(_grown_head(build, nose) - down, pose.lean)
    return [
        _rings(build, _HEAD, pose.lean, head=True),
        tube(rotated_forward(neck - down, pose.lean), 0.030 * h, sides=build.limb_sides),
        shaded(nose, [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]], crease_deg=30),
    ]


def _eyes(build: Build, pose: Pose) -> list[Mesh]:
    h = build.height_m
    made = []
    for x, z, wide, high in ((-0.018, 0.931, 0.010, 0.005), (0.018, 0.931, 0.010, 0.005)):
        ball = slab((wide * h, 0.006 * h, high * h), (x * h, 0.0495 * h, z * h))
        points = _grown_head(build, ball.vertices_m) - np.array([0, 0, HIP * h])
        made.append(Mesh(rotated_forward(points, pose.lean), ball.normals, ball.uv_m, ball.triangles))
    return made


def _legs(build: Build, at: Joints) -> list[Mesh]:
    h, g = build.height_m, build.girth
    radii = np.array([0.050, 0.046, 0.037, 0.035, 0.035, 0.024]) * h * g
    if not build.near:
        return [
            _tube([hip, knee, ankle], radii[[0, 2, 5]], sides=build.limb_sides)
            for hip, knee, ankle in zip(at.hip, at.knee, at.ankle, strict=True)
        ]
    return [
        _limb(hip, knee, ankle, radii, sides=build.limb_sides)
        for hip, knee, ankle in zip(at.hip, at.knee, at.ankle, strict=True)
    ]


def _arms(build: Build, at: Joints) -> tuple[list[Mesh], list[Mesh]]:
    h, g = build.height_m, build.girth
    upper, lower = [], []
    for shoulder, elbow, wrist in zip(at.shoulder, at.elbow, at.wrist, strict=True):
        inside = shoulder + np.array([-0.25 * shoulder[0], 0, 0.012 * h])
        below = shoulder + 0.25 * (elbow - shoulder)
        path = [inside, shoulder + np.array([0, 0, 0.004 * h]), below, elbow]
        upper.append(_tube(path, np.array([0.014, 0.026, 0.030, 0.0255]) * h * g, sides=build.limb_sides))
        lower.append(_tube([elbow, wrist], np.array([0.0245, 0.018]) * h * g, sides=build.limb_sides))
    return upper, lower


def _hands(build: Build, at: Joints) -> list[Mesh]:
    h = build.height_m
    return [
        _tube(
            [wrist, (wrist + tip) / 2, tip], np.array([0.015, 0.021, 0.009]) * h, sides=build.limb_sides - 2
        )
        for wrist, tip in zip(at.wrist, at.fingers, strict=True)
    ]


def _shoes(build: Build, at: Joints, pose: Pose) -> list[Mesh]:
    h = build.height_m
    shape = ((0.029, 0.078, -0.039, 0.036), (0.027, 0.068, -0.012, 0.030), (0.024, 0.030, 0.022, 0.0))
    rings = [
        superellipse(wide * h, long * h, z * h, power=2.6, sides=build.limb_sides)
        + np.array([0, ahead * h, 0])
        for wide, long, z, ahead in shape
    ]
    made = []
    for k, ankle in enumerate(at.ankle):
        # A foot that is off the ground points down as its shank swings back.
        swing = max(0.0, pose.knees[k] - pose.hips[k] - 8) if not pose.seated else 0.0
        turned = [rotated_forward(ring, 0.6 * swing) + ankle for ring in rings]
        made.append(loft(turned, crease_deg=60))
    return made


def _limb(start: Floats, joint: Floats, end: Floats, radii: Floats, *, sides: int) -> Mesh:
    near = [joint + 0.12 * (other - joint) for other in (start, end)]
    path = [start, (start + joint) / 2, near[0], near[1], joint + 0.35 * (end - joint), end]
    return _tube(path, radii, sides=sides)


def _tube(path: list[Floats], radii: Floats, *, sides: int) -> Mesh:
    return tube(np.array(path), radii.tolist(), sides=sides, crease_deg=_SMOOTH_DEG)
