"""Lamp posts, signs, traffic lights and what else stands on pavements.

Each faces -x, towards the traffic that comes along x, and stands to the right of the road: the road is at +y.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from tacos_framework import Light
from tacos_plugins.lighting import emitter_luminance_cd_m2, white_at
from tacos_worlds.kit.finishes import Finish
from tacos_worlds.kit.mesh import Mesh, merged
from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.shapes.boxes import slab
from tacos_worlds.kit.shapes.lofts import disc_stack, tube
from tacos_worlds.street.finishes import DARK_METAL, GALVANISED, GREEN_METAL, POSTER_VARIANTS, STONE
from tacos_worlds.street.panels import panel
from tacos_worlds.street.things.trees import shrub

_SIGN_M = 0.65
_LENS_M = (0.2, 0.6)
"""Edges of the glass of a street lamp [m]."""
_SIGNAL_CD_M2 = 400.0
"""Luminance of a traffic light that shows, beside lamps of `LAMP_LM` [cd/m2]."""


LAMP_LM = 7000.0
"""Luminous flux of a street lamp, before the scene's light is set to its illuminance [lm]."""
_LAMP_K = 3000.0
"""Warm white, as new street lamps are [K]."""


def lamp_post(rng: np.random.Generator, *, lit: bool = False) -> Piece:
    height, reach = float(rng.uniform(7.0, 7.6)), 1.7
    pole = tube([(0, 0, 0), (0, 0, 1.2), (0, 0, height - 0.3)], [0.10, 0.07, 0.05], sides=4)
    arm = tube([(0, 0, height - 0.3), (0, 0.5, height), (0, reach, height + 0.08)], 0.035, sides=3)
    head = slab((0.26, 0.8, 0.12), (0, reach + 0.3, height + 0.02))
    wide, long = _LENS_M
    lens = panel((-wide / 2, reach + 0.3 + long / 2, height + 0.015), (wide, 0, 0), (0, -long, 0))
    glass = Finish("", (0.72, 0.72, 0.68), roughness=0.9)
    body = (merged([pole, arm, head]), GALVANISED)
    if not lit:
        return Piece("lamp post", (body, (lens, glass)))
    flux = LAMP_LM * white_at(_LAMP_K)
    red, green, blue = emitter_luminance_cd_m2(flux, _LENS_M[0] * _LENS_M[1]).tolist()
    light = Light(
        position_m=np.array([0, reach + 0.3, height + 0.005], np.float32),
        flux_lm=flux.astype(np.float32),
        normal=np.array([0, 0, -1], np.float32),
        half_u_m=np.array([_LENS_M[0] / 2, 0, 0], np.float32),
        half_v_m=np.array([0, _LENS_M[1] / 2, 0], np.float32),
    )
    glowing = replace(glass, emission_cd_m2=(red, green, blue))
    return Piece("lamp post", (body, (lens, glowing)), lights=(light,))


def sign(rng: np.random.Generator) -> Piece:
    name, corners = (
        ("speed_limit", 16),
        ("no_entry", 16),
        ("stop", 8),
        ("crossing_ahead", 4),
    )[int(rng.integers(4))]
    low = float(rng.uniform(2.1, 2.4))
    front, back = _plate(corners, low + _SIGN_M / 2)
    post = tube([(0.03, 0, 0), (0.03, 0, low + _SIGN_M)], 0.03, sides=4)
    return Piece("sign", ((front, Finish(name, roughness=0.95)), (merged([back, post]), GALVANISED)))


def street_name(rng: np.random.Generator) -> Piece:
    post = tube([(0, 0, 0), (0, 0, 2.9)], 0.03, sides=4)
    plates = []
    for origin, along in (
        ((-0.035, 0.45, 2.55), (0.0, -0.9, 0.0)),
        ((0.035, -0.45, 2.55), (0.0, 0.9, 0.0)),
        ((-0.45, -0.035, 2.85), (0.9, 0.0, 0.0)),
        ((0.45, 0.035, 2.85), (-0.9, 0.0, 0.0)),
    ):
        plates.append(panel(origin, along, (0, 0, 0.26), u=(0, 1), v=(0.36, 0.64)))
    return Piece("sign", ((merged(plates), Finish("street_name", roughness=0.95)), (post, GALVANISED)))


def _plate(corners: int, middle_m: float) -> tuple[Mesh, Mesh]:
    """The printed front, which faces -x, and the bare back of a plate with so many corners."""
    turn = 2 * math.pi * (np.arange(corners) + 0.5) / corners
    radius = _SIGN_M / 2 / (math.cos(math.pi / corners))
    across, up = radius * np.cos(turn), radius * np.sin(turn)
    outline = np.vstack([np.column_stack([across, up]), [[0.0, 0.0]]])
    here = np.arange(corners)
    ring = np.column_stack([here, (here + 1) % corners, np.full(corners, corners)])

    def face(x: float, sign: int) -> Mesh:
        # Seen from -x, to the right is -y.
        points = np.column_stack([np.full(corners + 1, x), sign * outline[:, 0], middle_m + outline[:, 1]])
        return Mesh(
            points,
            np.tile([float(sign), 0.0, 0.0], (corners + 1, 1)),
            outline / _SIGN_M + 0.5,
            ring,
        )

    return face(0.0, -1), face(0.012, 1)


def traffic_light(rng: np.random.Generator, *, glows: bool = False) -> Piece:
    lit = int(rng.integers(3))
    post = tube([(0.1, 0, 0), (0.1, 0, 3.4)], 0.06, sides=5)
    case = slab((0.22, 0.32, 0.95), (0.1, 0, 2.5))
    parts: list[tuple[Mesh, Finish]] = [(merged([post, case]), DARK_METAL)]
    colours = ((0.02, 0.75, 0.25), (0.9, 0.5, 0.02), (0.9, 0.03, 0.02))
    for number, (red, green, blue) in enumerate(colours):
        lens = disc_stack([(0.11, 0.0), (0.07, 0.05)], sides=6).rotated(_FACING)
        lens = lens.moved(-0.01, 0, 2.66 + 0.29 * number)
        glow = 1.0 if number == lit else 0.12
        shown = _SIGNAL_CD_M2 if glows and number == lit else 0.0
        emission = (shown * red, shown * green, shown * blue)
        tint = (glow * red, glow * green, glow * blue)
        parts.append((lens, Finish("", tint, roughness=0.9, emission_cd_m2=emission)))
    return Piece("traffic light", tuple(parts))


_FACING = np.array([[0.0, 0, -1], [0, 1, 0], [1, 0, 0]])
"""Turns +z to -x."""


def litter_bin(rng: np.random.Generator) -> Piece:
    body = disc_stack([(0.24, 0.0), (0.28, 0.85), (0.30, 0.9), (0.10, 1.02)], sides=7)
    return Piece("bin", ((body, (GREEN_METAL, DARK_METAL)[int(rng.integers(2))]),))


def bollard(rng: np.random.Generator) -> Piece:
    return Piece(
        "bollard",
        (
            (
                disc_stack([(0.11, 0), (0.08, 0.12), (0.07, 0.85), (0.09, 0.92), (0.02, 1.0)], sides=5),
                DARK_METAL,
            ),
        ),
    )


def bench(rng: np.random.Generator) -> Piece:
    planks = [slab((1.8, 0.11, 0.04), (0, y, 0.44)) for y in (-0.16, 0.0, 0.16)]
    planks += [slab((1.8, 0.04, 0.11), (0, -0.26, z)) for z in (0.62, 0.78)]
    legs = [slab((0.06, 0.5, 0.44), (x, -0.03, 0)) for x in (-0.75, 0.75)]
    legs += [slab((0.06, 0.05, 0.5), (x, -0.29, 0.4)) for x in (-0.75, 0.75)]
    wood = Finish("bark", (0.75, 0.55, 0.36), roughness=0.95)
    return Piece("bench", ((merged(planks), wood), (merged(legs), DARK_METAL)))


def planter(rng: np.random.Generator) -> Piece:
    trough = slab((1.6, 0.6, 0.55), (0, 0, 0))
    return Piece("planter", ((trough, STONE), *shrub(rng, 0.9).moved(0, 0, 0.5).parts))


def shelter(rng: np.random.Generator) -> Piece:
    roof = slab((4.2, 1.6, 0.12), (0, 0, 2.45))
    posts = [
        slab((0.08, 0.08, 2.45), (x, y, 0)) for x in (-2.0, 0.0, 2.0) for y in (-0.7, 0.55) if x or y < 0
    ]
    seat = slab((2.6, 0.35, 0.06), (0, -0.5, 0.46))
    poster = Finish("poster", variant=int(rng.integers(POSTER_VARIANTS)), roughness=0.95)
    near = panel((-2.05, 0.55, 0.4), (0, -1.2, 0), (0, 0, 1.8), u=(0, 1), v=(0, 1))
    far = panel((-1.97, -0.65, 0.4), (0, 1.2, 0), (0, 0, 1.8), u=(0, 1), v=(0, 1))
    frame = [slab((0.07, 1.3, 0.1), (-2.01, -0.05, z)) for z in (0.3, 2.2)]
    return Piece(
        "bus shelter", ((merged([roof, *posts, seat, *frame]), DARK_METAL), (merged([near, far]), poster))
    )


def advertisement(rng: np.random.Generator) -> Piece:
    poster = Finish("poster", variant=int(rng.integers(POSTER_VARIANTS)), roughness=0.95)
    column = disc_stack([(0.62, 0.35), (0.62, 2.6)], sides=10)
    around = np.arctan2(column.vertices_m[:, 1], column.vertices_m[:, 0]) / (2 * np.pi) * 3
    column = Mesh(
        column.vertices_m,
        column.normals,
        np.column_stack([around, (column.vertices_m[:, 2] - 0.35) / 2.25]),
        column.triangles,
    )
    ends = [
        disc_stack([(0.7, 0), (0.66, 0.35)], sides=9),
        disc_stack([(0.72, 2.6), (0.45, 2.95), (0.02, 3.15)], sides=9),
    ]
    return Piece("advertisement", ((column, poster), (merged(ends), GREEN_METAL)))
