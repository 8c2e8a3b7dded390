"""Lamps: floor lamps and table lamps. A lamp that is on carries a light that encloses its shade."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tacos_framework import Light
from tacos_plugins.lighting import emitter_luminance_cd_m2, white_at
from tacos_worlds.kit.colours import linear, muted
from tacos_worlds.kit.finishes import Finish, Style
from tacos_worlds.kit.mesh import Floats, Mesh
from tacos_worlds.kit.piece import Piece, piece
from tacos_worlds.kit.shapes import disc_stack, tube

_CLEARANCE_M = 0.004
"""The light's sphere is this much larger than the shade, so that the shade does not block it [m]."""


def floor_lamp(rng: np.random.Generator, style: Style) -> Piece:
    height, radius = rng.uniform(1.45, 1.7), rng.uniform(0.17, 0.22)
    foot = [(0.14, 0), (0.14, 0.015), (0.05, 0.03), (0.012, 0.05)]
    pole = tube([[0, 0, 0.02], [0, 0, height - 0.1]], 0.011, sides=6)
    return _lamp(rng, [(disc_stack(foot, sides=16), style.metal), (pole, style.metal)], height, radius)


def table_lamp(rng: np.random.Generator, style: Style) -> Piece:
    height, radius = rng.uniform(0.42, 0.55), rng.uniform(0.12, 0.15)
    neck = height - radius
    base = [
        (0.07, 0),
        (0.075, 0.02),
        (0.05 + 0.03 * rng.uniform(), neck * 0.4),
        (0.02, neck * 0.8),
        (0.012, neck),
    ]
    glazed = Finish("glaze", linear(muted(rng, value=(0.4, 0.9))), roughness=0.25)
    return _lamp(
        rng, [(disc_stack(base, sides=14), glazed if rng.uniform() < 0.6 else style.wood)], height, radius
    )


def _lamp(rng: np.random.Generator, stand: list[tuple[Mesh, Finish]], height: float, radius: float) -> Piece:
    kind = rng.choice(["drum", "cone", "globe"])
    half = radius * (0.8 if kind != "globe" else 1.0)
    if kind == "globe":
        angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 9)[1:-1]
        profile = [(radius * np.cos(a), radius * np.sin(a)) for a in angle]
    else:
        top = 0.94 if kind == "drum" else 0.62
        profile = [
            (radius * 0.9, -half),
            (radius, -half + 0.004),
            (radius * top, half - 0.004),
            (radius * top * 0.9, half),
        ]
    centre = height - half
    shade = disc_stack([(r, centre + z) for r, z in profile], sides=16)
    cloth = Finish("linen", (0.85, 0.80, 0.70), roughness=0.9)
    return replace(piece("lamp", [*stand, (shade, cloth)]), can_light=True)


def switched_on(lamp: Piece, flux_lm: float, temperature_k: float) -> Piece:
    """The lamp with its shade (its last part) glowing, and a light around the shade.

    The shade is taken as a Lambertian emitter that sends out the whole flux from its surface; the light is a
    sphere around the shade, so that rays to it end before they meet the shade.
    """
    shade, cloth = lamp.parts[-1]
    low, high = shade.vertices_m.min(axis=0), shade.vertices_m.max(axis=0)
    centre = (low + high) / 2
    reach = float(np.linalg.norm(shade.vertices_m - centre, axis=1).max()) + _CLEARANCE_M
    flux = flux_lm * white_at(temperature_k)
    glow = emitter_luminance_cd_m2(flux, _area_m2(shade))
    light = Light(centre.astype(np.float32), flux.astype(np.float32), radius_m=reach)
    lit = replace(cloth, emission_cd_m2=(float(glow[0]), float(glow[1]), float(glow[2])))
    return replace(lamp, parts=(*lamp.parts[:-1], (shade, lit)), lights=(light,))


def _area_m2(mesh: Mesh) -> float:
    corners: Floats = mesh.vertices_m[mesh.triangles]
    doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(np.linalg.norm(doubled, axis=1).sum()) / 2
