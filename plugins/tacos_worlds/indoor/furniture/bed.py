"""Beds."""

from __future__ import annotations

import numpy as np

from tacos_worlds.kit.finishes import Finish, Style
from tacos_worlds.kit.mesh import Mesh, rotation_x
from tacos_worlds.kit.piece import Piece, piece
from tacos_worlds.kit.shapes import box, cushion, sheet

_SHEET = Finish("linen", (0.84, 0.83, 0.80), roughness=0.95)


def bed(rng: np.random.Generator, style: Style) -> Piece:
    return _bed(rng, style, width=float(rng.choice([1.4, 1.6, 1.8])), pillows=2)


def single_bed(rng: np.random.Generator, style: Style) -> Piece:
    return _bed(rng, style, width=float(rng.choice([0.9, 1.0])), pillows=1)


def _bed(rng: np.random.Generator, style: Style, *, width: float, pillows: int) -> Piece:
    length = float(rng.choice([2.0, 2.1]))
    frame_low, frame_height = rng.uniform(0.10, 0.18), rng.uniform(0.16, 0.22)
    mattress = rng.uniform(0.18, 0.24)
    top = frame_low + frame_height + mattress - 0.06
    head_height = rng.uniform(0.85, 1.15)
    upholstered = rng.uniform() < 0.5
    frame = style.upholstery if upholstered else style.wood
    front = length / 2
    parts: list[tuple[Mesh, Finish]] = [
        (box((width + 0.06, length + 0.04, frame_height), (0, 0, frame_low), bevel_m=0.015), frame),
        (
            cushion((width - 0.01, length - 0.02, mattress), (0, 0, top - mattress), round_m=0.05),
            _SHEET,
        ),
    ]
    for x in (-1, 1):
        for y in (-0.9, 0.9):
            parts.append(
                (box((0.08, 0.08, frame_low + 0.01), (x * (width / 2 - 0.08), y * front, 0)), style.wood)
            )
    if upholstered:
        columns = 3 if width > 1.2 else 2
        for column in range(columns):
            panel_width = (width + 0.08) / columns
            at = ((column - (columns - 1) / 2) * panel_width, -front - 0.07, frame_low)
            parts.append((cushion((panel_width, 0.11, head_height - frame_low), at, round_m=0.045), frame))
    else:
        parts.append(
            (box((width + 0.08, 0.05, head_height), (0, -front - 0.045, 0), bevel_m=0.012), style.wood)
        )
        parts.append(
            (box((width + 0.12, 0.08, 0.04), (0, -front - 0.045, head_height), bevel_m=0.01), style.wood)
        )
    parts.append((_duvet(rng, width, length, top), style.bedding))
    parts.append(
        (cushion((width + 0.03, 0.5, 0.035), (0, front - 0.42, top + 0.028), round_m=0.015), style.accent)
    )
    for pillow in range(pillows):
        place = (pillow - (pillows - 1) / 2) * width * 0.48
        soft = cushion(
            (min(0.68, width * 0.45 + 0.15), 0.42, 0.15), (0, 0, -0.075), round_m=0.07, puff_m=0.02
        )
        soft = soft.rotated(rotation_x(-0.32 + rng.uniform(-0.05, 0.05))).turned(rng.uniform(-0.06, 0.06))
        parts.append(
            (
                soft.moved(place, -front + 0.30, top + 0.10),
                _SHEET if pillow or pillows == 1 else style.bedding,
            )
        )
    return piece("bed", parts)


def _duvet(rng: np.random.Generator, width: float, length: float, top: float) -> Mesh:
    """A quilt over the mattress: flat on top, bent down at sides and foot, with shallow folds."""
    across = np.linspace(-1, 1, 11)
    along = np.linspace(0, 1, 9)
    reach, drop = width / 2 + 0.03, 0.24
    half_span = reach + drop
    x_arc = across * half_span
    over_side = np.clip(np.abs(x_arc) - reach, 0, None)
    x = np.sign(x_arc) * np.minimum(np.abs(x_arc), reach + 0.02 * np.sqrt(over_side / drop + 1e-9))
    span = length * 0.70 + drop
    y_arc = along * span
    foot = length / 2 + 0.03
    start = foot - length * 0.70
    over_foot = np.clip(start + y_arc - foot, 0, None)
    y = np.minimum(start + y_arc, foot + 0.02)
    grid_x, grid_y = np.meshgrid(x, y)
    down = (over_side[None, :] ** 3 + over_foot[:, None] ** 3) ** (1 / 3)
    folds = rng.normal(0, 0.008, (9, 11)) + 0.012 * np.sin(np.linspace(0, 9, 11) + rng.uniform(0, 6))[None, :]
    grid_z = top + 0.045 - down + np.where(down > 0, 0, folds)
    points = np.stack([grid_x, grid_y, grid_z], axis=2)
    return sheet(points, thickness_m=0.02)
