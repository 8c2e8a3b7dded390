"""Windows in outer walls, with sills and curtains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tacos_worlds.indoor.structure.sides import Opening, Side
from tacos_worlds.kit.finishes import WHITE_LACQUER, Finish, Style
from tacos_worlds.kit.mesh import Mesh
from tacos_worlds.kit.piece import BACKGROUND, Piece
from tacos_worlds.kit.shapes import box, panel, sheet, tube

_RECESS_M = 0.14
_CURTAIN_LINE_M = 0.12
CURTAIN_M = 0.2
"""How far curtains and sills reach into the room [m]."""


@dataclass(frozen=True)
class Window:
    """A window: its hole, and what it takes of the wall with its curtains, along the side [m]."""

    opening: Opening
    low_m: float
    high_m: float
    curtains: bool


def draw_windows(rng: np.random.Generator, side: Side, ceiling_height_m: float, *, wet: bool) -> list[Window]:
    if not side.outer or rng.uniform() < 0.15:
        return []
    count = 1 if wet or side.length_m < 6.5 or rng.uniform() < 0.4 else 2
    found = []
    for k in range(count):
        width = rng.uniform(0.6, 0.9) if wet else rng.uniform(1.1, 1.9)
        sill = rng.uniform(1.35, 1.5) if wet else rng.uniform(0.8, 0.95)
        head = min(
            ceiling_height_m - 0.45, sill + (rng.uniform(0.55, 0.7) if wet else rng.uniform(1.25, 1.45))
        )
        share = side.length_m / count
        middle = share * (k + 0.5) + rng.uniform(-0.12, 0.12) * share
        curtains = not wet and rng.uniform() < 0.8
        margin = 0.45 if curtains else 0.1
        hole = Opening(middle - width / 2, middle + width / 2, sill, head)
        if head - sill > 0.4:
            found.append(Window(hole, hole.low_m - margin, hole.high_m + margin, curtains))
    return found


def window(rng: np.random.Generator, side: Side, drawn: Window, style: Style) -> Piece:
    hole = drawn.opening
    width, height = hole.high_m - hole.low_m, hole.head_m - hole.sill_m
    low, sill, head = hole.low_m, hole.sill_m, hole.head_m
    white = Finish("plaster", (0.85, 0.85, 0.84), roughness=0.9)
    deep = -_RECESS_M
    reveals = [
        panel([low, 0, sill], [0, deep, 0], [0, 0, height]),
        panel([hole.high_m, deep, sill], [0, -deep, 0], [0, 0, height]),
        panel([low, deep, head], [0, -deep, 0], [width, 0, 0]),
        panel([low, 0, sill], [0, deep, 0], [width, 0, 0]),
    ]
    parts: list[tuple[Mesh, Finish]] = [
        (mesh if _faces(mesh, low + width / 2, sill + height / 2) else _flipped(mesh), white)
        for mesh in reveals
    ]
    pane_at = deep + 0.02
    pane = panel(
        [hole.high_m, pane_at, sill],
        [-width, 0, 0],
        [0, 0, height],
        step_m=0.7,
        uv_m=(rng.uniform(0, 2), 0.0),
    )
    parts.append(
        (
            pane,
            Finish(
                "view_outside", variant=int(rng.integers(2)), texture_size_m=height * 1.05, roughness=0.12
            ),
        )
    )
    bar = 0.06
    middle = low + width / 2
    parts += [
        (box((width, 0.05, bar), (middle, pane_at + 0.015, sill), bevel_m=0.005), WHITE_LACQUER),
        (box((width, 0.05, bar), (middle, pane_at + 0.015, head - bar), bevel_m=0.005), WHITE_LACQUER),
        (
            box(
                (width + 0.1, _RECESS_M + 0.05, 0.03), (middle, deep / 2 + 0.025, sill - 0.005), bevel_m=0.008
            ),
            WHITE_LACQUER,
        ),
    ]
    uprights = (0.0, 0.5, 1.0) if width > 0.95 else (0.0, 1.0)
    for share in uprights:
        x = low + bar / 2 + share * (width - bar)
        parts.append((box((bar, 0.05, height), (x, pane_at + 0.015, sill), bevel_m=0.005), WHITE_LACQUER))
    if drawn.curtains:
        top, bottom = head + 0.16, float(rng.choice([0.04, sill - 0.25]))
        open_share = rng.uniform(0.75, 1.0)
        for start, end in (
            (low - 0.38, low + width * (1 - open_share) / 2),
            (hole.high_m - width * (1 - open_share) / 2, hole.high_m + 0.38),
        ):
            parts.append((_curtain(rng, start, end, bottom, top), style.curtain))
        rod = [
            [low - 0.44, _CURTAIN_LINE_M, top + 0.01],
            [middle, _CURTAIN_LINE_M, top + 0.01],
            [hole.high_m + 0.44, _CURTAIN_LINE_M, top + 0.01],
        ]
        parts.append((tube(rod, 0.014, sides=6), style.metal))
    return Piece(BACKGROUND, tuple((side.place_mesh(mesh), finish) for mesh, finish in parts))


def _curtain(rng: np.random.Generator, start: float, end: float, bottom: float, top: float) -> Mesh:
    columns = max(9, round((end - start) / 0.036))
    x = np.linspace(end, start, columns)
    phase = np.cumsum(rng.uniform(0.8, 1.5, columns)) * 1.2
    rows = np.linspace(bottom, top, 3)
    gather = 0.03 * (1.15 - 0.35 * (rows - bottom) / (top - bottom))
    points = np.empty((3, columns, 3))
    points[..., 0] = x
    points[..., 1] = _CURTAIN_LINE_M + gather[:, None] * np.sin(phase)[None, :]
    points[..., 2] = rows[:, None]
    return sheet(points, thickness_m=0.002)


def _faces(mesh: Mesh, x: float, z: float) -> bool:
    """True if a reveal faces the middle of its hole."""
    towards = np.array([x, 0.0, z]) - mesh.vertices_m.mean(axis=0)
    towards[1] = 0.0
    return float(mesh.normals[0] @ towards) > 0


def _flipped(mesh: Mesh) -> Mesh:
    return Mesh(mesh.vertices_m, -mesh.normals, mesh.uv_m, mesh.triangles[:, ::-1])
