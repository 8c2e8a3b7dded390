"""Cars, vans and buses: x forward, standing on z = 0, centred."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tacos_worlds.kit.finishes import Finish
from tacos_worlds.kit.mesh import Mesh, merged, shaded
from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.shapes.boxes import slab
from tacos_worlds.kit.shapes.lofts import loft
from tacos_worlds.street.finishes import CAR_GLASS, HEADLIGHT, RIM, TAIL_LIGHT, TRIM, TYRE
from tacos_worlds.street.panels import panel

PLATE_VARIANTS = 3
_WHEEL_SIDES = 8
_COARSE_PARTS = 3
"""So many of a car's parts show from afar: body, glass, tyres."""
_PAINTS = (
    (0.62, 0.63, 0.64),
    (0.80, 0.80, 0.78),
    (0.03, 0.03, 0.035),
    (0.16, 0.17, 0.19),
    (0.42, 0.03, 0.03),
    (0.03, 0.07, 0.25),
    (0.05, 0.16, 0.30),
    (0.04, 0.13, 0.07),
    (0.55, 0.42, 0.10),
    (0.36, 0.30, 0.22),
)


@dataclass(frozen=True)
class Body:
    """The shape of a vehicle."""

    length_m: float  # outer
    width_m: float  # outer
    side: tuple[tuple[float, float, float], ...]
    """(position, lowest, highest) of the lower body from the back to the front: position as a share of half
    the length, heights in metres."""
    cabin: tuple[tuple[float, float], ...]
    """(position, height) of the glass: back and front at its foot, back and front at its top."""
    wheel_m: float = 0.32  # radius of the wheels [m]
    axles: tuple[float, float] = (-0.62, 0.64)
    """Positions of rear and front axle as a share of half the length."""


HATCHBACK = Body(
    4.05,
    1.76,
    ((-1.0, 0.42, 0.74), (-0.96, 0.26, 0.92), (-0.84, 0.21, 0.97), (0.30, 0.20, 0.95), (0.82, 0.21, 0.80),
     (0.97, 0.26, 0.66), (1.0, 0.38, 0.56)),
    ((-0.93, 0.93), (0.46, 0.92), (-0.62, 1.45), (0.06, 1.47)),
)  # fmt: skip
SALOON = Body(
    4.65,
    1.82,
    ((-1.0, 0.42, 0.80), (-0.97, 0.28, 0.96), (-0.60, 0.21, 1.01), (0.34, 0.20, 0.96), (0.84, 0.21, 0.80),
     (0.97, 0.26, 0.66), (1.0, 0.38, 0.56)),
    ((-0.70, 0.98), (0.46, 0.93), (-0.36, 1.42), (0.08, 1.44)),
)  # fmt: skip
ESTATE = Body(
    4.55,
    1.86,
    ((-1.0, 0.48, 0.86), (-0.97, 0.32, 1.04), (-0.84, 0.27, 1.08), (0.36, 0.26, 1.05), (0.84, 0.27, 0.94),
     (0.97, 0.32, 0.78), (1.0, 0.44, 0.66)),
    ((-0.94, 1.04), (0.50, 1.02), (-0.80, 1.64), (0.14, 1.66)),
    wheel_m=0.36,
)  # fmt: skip
VAN = Body(
    5.3,
    2.0,
    ((-1.0, 0.40, 2.15), (-0.985, 0.30, 2.28), (0.30, 0.25, 2.30), (0.52, 0.25, 1.18), (0.90, 0.26, 1.02),
     (0.98, 0.30, 0.86), (1.0, 0.42, 0.72)),
    ((0.26, 1.16), (0.70, 1.10), (0.22, 2.18), (0.40, 2.16)),
    wheel_m=0.34,
)  # fmt: skip
BODIES = (HATCHBACK, HATCHBACK, SALOON, SALOON, ESTATE, VAN)


def draw_car(rng: np.random.Generator, *, far: bool = False) -> Piece:
    """A random car or van, without its small parts where it is only seen from `far`."""
    body = BODIES[int(rng.integers(len(BODIES)))]
    white_van = body is VAN and rng.uniform() < 0.6
    tint = (0.78, 0.78, 0.76) if white_van else _PAINTS[int(rng.integers(len(_PAINTS)))]
    plate = int(rng.integers(PLATE_VARIANTS))
    made = car(body, Finish("car_paint", tint, roughness=0.35), plate=plate)
    return replace(made, parts=made.parts[:_COARSE_PARTS]) if far else made


def car(body: Body, paint: Finish, *, plate: int = 0) -> Piece:
    half, wide = body.length_m / 2, body.width_m / 2
    lower = loft([_section(x * half, low, high, wide) for x, low, high in body.side], crease_deg=50)
    (x0, z0), (x1, z1), (x2, z2), (x3, z3) = ((x * half, z) for x, z in body.cabin)
    foot, head = 0.95 * wide, 0.76 * wide
    glass = loft([_plan(x0, x1, z0, z1, foot), _plan(x2, x3, z2, z3, head)], capped=False, crease_deg=30)
    eaves = _plan(x2 - 0.04, x3 + 0.04, z2 - 0.03, z3 - 0.03, head + 0.02)
    crown = _plan(x2 + 0.1, x3 - 0.1, z2 + 0.05, z3 + 0.05, head - 0.1)
    roof = [loft([eaves, crown], capped=False, crease_deg=60), _cap(crown)]
    joints = [
        ((x0, z0), (x2, z2)),
        ((x1, z1), (x3, z3)),
        (((x0 + x1) / 2, (z0 + z1) / 2), ((x2 + x3) / 2, (z2 + z3) / 2)),
    ]
    pillars = [
        _pillar((low[0], side * (foot + 0.01), low[1]), (high[0], side * (head + 0.015), high[1]), side)
        for side in (-1, 1)
        for low, high in joints
    ]
    wheels = [
        _wheel(body.wheel_m, side, (at * half, side * (wide - 0.09), body.wheel_m))
        for at in body.axles
        for side in (-1, 1)
    ]
    nose, tail = body.side[-2], body.side[1]
    lamp_z, tail_z = 0.62 * nose[2] + 0.38 * nose[1], 0.66 * tail[2] + 0.34 * tail[1]
    front_m, back_m = half * 0.99 + 0.012, -half * 0.99 - 0.012
    lamps = [_facing_front(front_m, s * (wide - 0.34), lamp_z, 0.36, 0.13) for s in (-1, 1)]
    tails = [_facing_back(back_m, s * (wide - 0.27), tail_z, 0.24, 0.18) for s in (-1, 1)]
    mirrors = [slab((0.12, 0.16, 0.11), (x1 * 0.82, s * (wide + 0.06), z1 + 0.02)) for s in (-1, 1)]
    trim = [_facing_front(half + 0.01, 0, 0.42, 0.9, 0.14), _facing_back(-half - 0.01, 0, 0.45, 1.2, 0.1)]
    plates = [
        _facing_front(half + 0.02, 0, 0.52, 0.52, 0.12),
        _facing_back(-half - 0.02, 0, 0.62, 0.52, 0.12),
    ]
    return Piece(
        "car",
        (
            (merged([lower, *roof, *pillars]), paint),
            (glass, CAR_GLASS),
            (merged([tyre for tyre, _ in wheels]), TYRE),
            (merged(mirrors), paint),
            (merged([rim for _, rim in wheels]), RIM),
            (merged(lamps), HEADLIGHT),
            (merged(tails), TAIL_LIGHT),
            (merged(trim), TRIM),
            (merged(plates), Finish("number_plate", variant=plate, roughness=0.95)),
        ),
    )


def _facing_front(x: float, y: float, z: float, width_m: float, height_m: float) -> Mesh:
    """A plate that faces forward; its texture shows the middle of the tile."""
    return panel((x, y - width_m / 2, z), (0, width_m, 0), (0, 0, height_m), u=(0, 1), v=(0.38, 0.62))


def _facing_back(x: float, y: float, z: float, width_m: float, height_m: float) -> Mesh:
    return panel((x, y + width_m / 2, z), (0, -width_m, 0), (0, 0, height_m), u=(0, 1), v=(0.38, 0.62))


def _cap(ring: NDArray[np.float64]) -> Mesh:
    here = np.arange(len(ring))
    middle = np.full(len(ring), len(ring))
    triangles = np.column_stack([here, (here + 1) % len(ring), middle])
    return shaded(np.vstack([ring, ring.mean(axis=0)]), triangles, crease_deg=60)


def _pillar(low_m: tuple[float, ...], high_m: tuple[float, ...], side: int) -> Mesh:
    low, high, half = np.array(low_m), np.array(high_m), np.array([0.045, 0, 0])
    corners = np.array([low - half, low + half, high + half, high - half])
    return shaded(corners[::-1] if side > 0 else corners, [[0, 1, 2], [0, 2, 3]])


def _section(x_m: float, low_m: float, high_m: float, half_width_m: float) -> NDArray[np.float64]:
    """Ring of the lower body across the car, counter-clockwise seen from the front."""
    taper = 1.0 if high_m - low_m > 0.5 else 0.86
    w, h = taper * half_width_m, high_m - low_m
    shape = [
        (-0.92, 0.0), (0.92, 0.0), (1.0, 0.18), (1.0, 0.66), (0.90, 1.0), (-0.90, 1.0), (-1.0, 0.66),
        (-1.0, 0.18),
    ]  # fmt: skip
    return np.array([(x_m, w * y, low_m + h * z) for y, z in shape])


def _plan(x0: float, x1: float, z0: float, z1: float, half_width_m: float) -> NDArray[np.float64]:
    """Ring of the cabin, counter-clockwise seen from above, from its back (x0, z0) to its front (x1, z1)."""
    cut = 0.12
    w = half_width_m
    return np.array(
        [
            (x0, -w + cut, z0),
            (x0 + cut, -w, z0),
            (x1 - cut, -w, z1),
            (x1, -w + cut, z1),
            (x1, w - cut, z1),
            (x1 - cut, w, z1),
            (x0 + cut, w, z0),
            (x0, w - cut, z0),
        ]
    )


def _wheel(radius_m: float, side: int, at_m: tuple[float, float, float]) -> tuple[Mesh, Mesh]:
    """A tyre and its rim at a place, the rim to the outside of that side of the car."""
    turn = -side * np.arange(_WHEEL_SIDES) * 2 * np.pi / _WHEEL_SIDES
    ring = radius_m * np.column_stack([np.cos(turn), np.zeros(_WHEEL_SIDES), np.sin(turn)])
    out = np.array([0, side * 0.1, 0])
    tyre = [loft([ring - out, ring + out], capped=False, crease_deg=70), _cap(ring + out)]
    rim = _cap(0.64 * ring + 1.06 * out)
    return merged(tyre).moved(*at_m), rim.moved(*at_m)
