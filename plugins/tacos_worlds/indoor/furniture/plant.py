"""Pot plants."""

from __future__ import annotations

import math

import numpy as np

from tacos_worlds.kit.colours import linear, muted
from tacos_worlds.kit.finishes import SOIL, Finish, Style
from tacos_worlds.kit.mesh import Mesh, merged, rotation_z
from tacos_worlds.kit.piece import Piece, piece
from tacos_worlds.kit.shapes import disc_stack, sheet, tube

_GREENS = ((0.30, 0.55, 0.22), (0.20, 0.42, 0.18), (0.45, 0.60, 0.25), (0.25, 0.45, 0.28))


def floor_plant(rng: np.random.Generator, style: Style) -> Piece:
    """A large plant for a corner: broad leaves on stems, a palm, or upright blades."""
    return _plant(
        rng, height=rng.uniform(0.9, 1.6), pot=rng.uniform(0.15, 0.2), leaves=int(rng.integers(16, 26))
    )


def small_plant(rng: np.random.Generator, style: Style) -> Piece:
    return _plant(rng, height=rng.uniform(0.22, 0.36), pot=rng.uniform(0.06, 0.08), leaves=11)


def _plant(rng: np.random.Generator, *, height: float, pot: float, leaves: int) -> Piece:
    pot_height = pot * rng.uniform(1.4, 2.0)
    wall = pot * 0.1
    profile = [
        (pot * 0.72, 0),
        (pot * 0.76, pot * 0.08),
        (pot, pot_height - wall),
        (pot * 1.02, pot_height),
        (pot * 0.9, pot_height),
        (pot * 0.88, pot_height * 0.88),
    ]
    vessel = [
        Finish("glaze", linear(muted(rng, value=(0.4, 0.95))), roughness=0.3),
        Finish("plaster", (0.48, 0.24, 0.15), roughness=0.9),
        Finish("wicker", texture_size_m=0.2, roughness=0.9),
    ][int(rng.integers(3))]
    earth = disc_stack([(pot * 0.88, pot_height * 0.80), (pot * 0.87, pot_height * 0.9)], sides=12)
    green = Finish(
        "foliage",
        _GREENS[int(rng.integers(len(_GREENS)))],
        texture_size_m=max(0.1, height * 0.25),
        roughness=0.5,
    )
    foliage, stems = [], []
    kind = str(rng.choice(["broad", "palm", "blades"]))
    crown = height - pot_height
    for leaf in range(leaves):
        turn = leaf * math.pi * (3 - math.sqrt(5)) + rng.normal(0, 0.2)
        rise = (leaf + 0.5) / leaves
        if kind == "blades":
            length, width, lean = crown * rng.uniform(0.6, 1.0), 0.045 * crown + 0.02, rng.uniform(0.05, 0.3)
            base = np.array([rng.uniform(0, 0.45) * pot, 0, pot_height * 0.88])
            foliage.append(_leaf(length, width, lean, curl=0.3).moved(*base).rotated(rotation_z(turn)))
            continue
        if kind == "palm":
            length, width, lean = crown * rng.uniform(0.45, 0.65), 0.05 * crown + 0.02, rng.uniform(0.35, 1.0)
            base = np.array([0.01, 0, pot_height * 0.9 + crown * 0.45 * rise])
        else:
            length, width, lean = (
                crown * rng.uniform(0.22, 0.34),
                crown * rng.uniform(0.14, 0.2),
                rng.uniform(0.7, 1.3),
            )
            base = np.array([crown * 0.10 * (1.2 - rise), 0, pot_height * 0.9 + crown * (0.15 + 0.7 * rise)])
            stem_top = base + np.array([0.01, 0, 0.01])
            stems.append(
                tube(
                    np.stack([[0.01, 0, pot_height * 0.85], stem_top]), 0.004 + 0.003 * crown, sides=3
                ).rotated(rotation_z(turn))
            )
        foliage.append(_leaf(length, width, lean, curl=0.9).moved(*base).rotated(rotation_z(turn)))
    if kind == "palm":
        trunk = [
            [0, 0, pot_height * 0.8],
            [0.01, 0.01, pot_height + crown * 0.25],
            [0, 0, pot_height + crown * 0.42],
        ]
        stems.append(tube(trunk, [0.03 * crown + 0.01, 0.025 * crown + 0.006, 0.01], sides=6))
    parts: list[tuple[Mesh, Finish]] = [
        (disc_stack(profile, sides=12), vessel),
        (earth, SOIL),
        (merged(foliage), green),
    ]
    if stems:
        parts.append((merged(stems), Finish("board", (0.30, 0.32, 0.16), roughness=0.8)))
    return piece("plant", parts)


def _leaf(length: float, width: float, lean_rad: float, *, curl: float) -> Mesh:
    """A leaf that starts at the origin, rises leaning towards +x, and bends over by `curl` [rad]."""
    along = np.linspace(0, 1, 4)
    angle = lean_rad + curl * along
    step = length / 3
    x = np.concatenate([[0], np.cumsum(np.sin(angle[:-1]) * step)])
    z = np.concatenate([[0], np.cumsum(np.cos(angle[:-1]) * step)])
    half = width * np.array([0.14, 0.48, 0.44, 0.02])
    side = np.array([-1.0, 0.0, 1.0])
    points = np.empty((3, 4, 3))
    points[..., 0] = x - 0.15 * np.abs(side)[:, None] * half * np.cos(angle)
    points[..., 1] = side[:, None] * half
    points[..., 2] = z + 0.3 * np.abs(side)[:, None] * half * np.sin(angle)
    return sheet(points, thickness_m=0.0015)
