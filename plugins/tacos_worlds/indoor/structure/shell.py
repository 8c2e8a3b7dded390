"""The shell of a room: floor, ceiling, wall faces, skirting boards."""

from __future__ import annotations

from tacos_worlds.indoor.structure.sides import Opening, Side, wall_face
from tacos_worlds.kit.finishes import Finish, Style
from tacos_worlds.kit.mesh import Mesh
from tacos_worlds.kit.piece import BACKGROUND, Piece
from tacos_worlds.kit.rectangle import Rect
from tacos_worlds.kit.shapes import panel

_SKIRTING_M = 0.08
_SKIRTING_DEPTH_M = 0.014
_TILED_M = 2.1
"""Height of the tiles in a bathroom [m]."""


def shell(
    clear: Rect,
    sides: list[Side],
    openings: list[list[Opening]],
    doors: list[list[Opening]],
    ceiling_height_m: float,
    style: Style,
    tiles: Finish | None,
    step_m: float,
) -> Piece:
    """All faces of a room. `openings` are all holes of each side, `doors` those that reach the floor."""
    width, depth = clear.size
    white = Finish("plaster", (0.86, 0.86, 0.85), roughness=0.95)
    parts: list[tuple[Mesh, Finish]] = [
        (
            panel(
                [clear.x0, clear.y0, 0],
                [width, 0, 0],
                [0, depth, 0],
                step_m=step_m,
                uv_m=(clear.x0, clear.y0),
            ),
            style.floor,
        ),
        (panel([clear.x0, clear.y1, ceiling_height_m], [width, 0, 0], [0, -depth, 0], step_m=step_m), white),
    ]
    tiled = min(_TILED_M, ceiling_height_m - 0.3) if tiles else 0.0
    for side, holes, passages in zip(sides, openings, doors, strict=True):
        if tiles:
            parts.append((wall_face(side, holes, 0.0, tiled, step_m), tiles))
        parts.append((wall_face(side, holes, tiled, ceiling_height_m, step_m), style.wall))
        if not tiles:
            parts += [(mesh, style.trim) for mesh in _skirting(side, passages)]
    return Piece(BACKGROUND, tuple(parts))


def _skirting(side: Side, passages: list[Opening]) -> list[Mesh]:
    ends = [0.0]
    for hole in sorted(passages, key=lambda h: h.low_m):
        ends += [hole.low_m - 0.045, hole.high_m + 0.045]
    ends.append(side.length_m)
    boards = []
    for low, high in zip(ends[::2], ends[1::2], strict=True):
        if high - low < 0.05:
            continue
        run = [high - low, 0, 0]
        front = panel([high, _SKIRTING_DEPTH_M, 0], [low - high, 0, 0], [0, 0, _SKIRTING_M], step_m=0.8)
        top = panel([low, _SKIRTING_DEPTH_M, _SKIRTING_M], run, [0, -_SKIRTING_DEPTH_M, 0], step_m=0.8)
        top = Mesh(top.vertices_m, -top.normals, top.uv_m, top.triangles[:, ::-1])
        boards += [side.place_mesh(front), side.place_mesh(top)]
    return boards
