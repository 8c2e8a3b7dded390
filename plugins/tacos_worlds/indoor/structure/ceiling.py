"""Ceiling lights."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tacos_framework import Light
from tacos_plugins.lighting import emitter_luminance_cd_m2, white_at
from tacos_worlds.kit.finishes import CHROME, WHITE_LACQUER, Finish
from tacos_worlds.kit.piece import BACKGROUND, Piece
from tacos_worlds.kit.rectangle import Rect
from tacos_worlds.kit.shapes import box, disc_stack, extruded

_DROP_M = 0.075
_PROUD_M = 0.001
"""The diffuser stands out of its fitting so little that hardly any light leaves it sideways [m]."""
_GAP_M = 0.003
"""The light lies this far below the surface that shows it [m]."""


def ceiling_lights(
    rng: np.random.Generator,
    room: Rect,
    ceiling_height_m: float,
    count: int,
    flux_lm: float,
    temperature_k: float,
) -> list[Piece]:
    """`count` equal fittings along the middle of a room that together send out `flux_lm` [lm]."""
    width, depth = room.size
    along_x = width >= depth
    rim = CHROME if rng.uniform() < 0.3 else WHITE_LACQUER
    made = _panel(rng, rim, along_x) if rng.uniform() < 0.5 else _disc(rng, rim)
    flux = flux_lm / count * white_at(temperature_k)
    fitting = _lit(*made, flux)
    low = ceiling_height_m - _DROP_M
    found = []
    for k in range(count):
        share = (k + 0.5) / count
        x = room.x0 + width * (share if along_x else 0.5)
        y = room.y0 + depth * (0.5 if along_x else share)
        found.append(fitting.moved(x, y, low))
    return found


def _panel(rng: np.random.Generator, rim: Finish, along_x: bool) -> tuple[Piece, tuple[float, float]]:
    length, breadth = (0.6, 0.6) if rng.uniform() < 0.5 else (1.2, 0.3)
    size = (length, breadth) if along_x else (breadth, length)
    body = box((size[0] + 0.05, size[1] + 0.05, _DROP_M - _PROUD_M), (0, 0, _PROUD_M), bevel_m=0.006)
    glow = box((size[0], size[1], 0.02), (0, 0, 0), bevel_m=0.002)
    return Piece(BACKGROUND, ((body, rim), (glow, _DIFFUSER))), size


def _disc(rng: np.random.Generator, rim: Finish) -> tuple[Piece, tuple[float, float]]:
    radius = rng.uniform(0.2, 0.3)
    body = disc_stack(
        [(radius + 0.02, _PROUD_M), (radius + 0.025, 0.02), (radius + 0.025, _DROP_M)], sides=24
    )
    turn = np.arange(24) * 2 * np.pi / 24
    glow = extruded(radius * np.column_stack([np.cos(turn), np.sin(turn)]), 0.03)
    edge = float(np.sqrt(np.pi)) * radius  # the square of equal area
    return Piece(BACKGROUND, ((body, rim), (glow, _DIFFUSER))), (edge, edge)


_DIFFUSER = Finish("", (0.85, 0.85, 0.85), roughness=0.9)


def _lit(fitting: Piece, size_m: tuple[float, float], flux_lm: np.ndarray) -> Piece:
    glow = emitter_luminance_cd_m2(flux_lm, size_m[0] * size_m[1])
    mesh, finish = fitting.parts[-1]
    lit = replace(finish, emission_cd_m2=(float(glow[0]), float(glow[1]), float(glow[2])))
    light = Light(
        np.array([0.0, 0.0, -_GAP_M]),
        flux_lm,
        normal=np.array([0.0, 0.0, -1.0]),
        half_u_m=np.array([size_m[0] / 2, 0.0, 0.0]),
        half_v_m=np.array([0.0, size_m[1] / 2, 0.0]),
    )
    return replace(fitting, parts=(*fitting.parts[:-1], (mesh, lit)), lights=(light,))
