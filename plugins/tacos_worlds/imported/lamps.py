"""Light sources of an imported world: the file's own, those its glowing surfaces make, and placed ones."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from tacos_framework import Light
from tacos_plugins.lighting import photopic, white_at
from tacos_worlds.imported.floor import Floor
from tacos_worlds.kit.models.model import PunctualLight
from tacos_worlds.kit.models.patch import Patch, welded

MOST_LIGHTS = 24
"""More sources than these are left out, the weakest first, and their light is given to the others."""
SUN_DISTANCE_M = 10_000.0
"""Far enough for parallel rays, near enough for float32 rays [m]."""
SUN_RADIUS_DEG = 0.2666
_BESIDE_M = 0.01
_BULB_RADIUS_M = 0.05
_SPOT_EDGE_M = 0.05
_FLAT = 0.9
_LAMP_SPACING_M = 3.5
_FROM_WALLS_M = 1.0
_LAMP_EDGE_M = 0.6
_LAMP_EXITANCE_LM_M2 = 140.0
_LAMP_K = 4000.0


def of_file(lights: Sequence[PunctualLight], turn: NDArray[np.float64]) -> Iterator[Light]:
    """Lights of a file as those of a world.

    A point of I candela sends out ``4 pi I`` lumens. A spot becomes a small Lambertian square of as many
    candela ahead, ``pi I`` lumens, whatever its cone. A directional light of E lux is a small sphere far
    away.
    """
    rotation = turn / np.cbrt(np.linalg.det(turn))
    for light in lights:
        colour = light.colour * light.intensity
        if not np.isfinite(colour).all() or not colour.max() > 0:
            continue
        position, towards = turn @ light.position, rotation @ light.direction
        if light.kind == "point":
            yield Light(_f32(position), _f32(4 * math.pi * colour), radius_m=_BULB_RADIUS_M)
        elif light.kind == "spot":
            yield _square(position, towards, math.pi * colour, _SPOT_EDGE_M)
        else:
            yield sun(-towards, colour)


def sun(towards: NDArray[np.float64], lux: NDArray[np.float64]) -> Light:
    """A sun seen along a unit vector that gives a surface facing it (3,) illuminance [lux]."""
    return Light(
        _f32(SUN_DISTANCE_M * towards),
        _f32(lux * 4 * math.pi * SUN_DISTANCE_M**2),
        radius_m=SUN_DISTANCE_M * math.tan(math.radians(SUN_RADIUS_DEG)),
    )


def of_glowing(patch: Patch, luminance_cd_m2: NDArray[np.float64]) -> Iterator[Light]:
    """Lights just off the connected pieces of a surface that glows.

    A flat piece is a rectangle of as much area, any other a sphere; both send out ``pi L`` per area.
    """
    corner = welded(patch.vertices_m)[patch.triangles]
    size = int(corner.max(initial=-1)) + 1
    edges = corner[:, [0, 1]].reshape(-1), corner[:, [1, 2]].reshape(-1)
    joined = coo_array((np.ones(len(edges[0]), np.int8), edges), shape=(size, size))
    _, label = connected_components(joined, directed=False)
    piece = label[corner[:, 0]]
    for each in np.unique(piece):
        own = patch.with_triangles(patch.triangles[piece == each])
        area = own.areas_m2.sum()
        mean = own.crosses.sum(axis=0) / 2
        flux = math.pi * area * luminance_cd_m2
        centre = (own.vertices_m[own.triangles].mean(axis=1) * own.areas_m2[:, None]).sum(axis=0) / area
        if np.linalg.norm(mean) >= _FLAT * area:
            yield _rectangle(own.vertices_m, centre, mean / np.linalg.norm(mean), area, flux)
        else:
            radius = float(np.linalg.norm(own.vertices_m - centre, axis=1).max()) + _BESIDE_M
            yield Light(_f32(centre), _f32(flux), radius_m=radius)


def placed(floor: Floor) -> tuple[list[Light], list[Patch]]:
    """Square lamps under the ceiling above a floor, spread evenly, and the panels that show them.

    Where there is no ceiling there is no lamp. Panels are of skin -1.
    """
    under = np.isfinite(floor.headroom_m)
    if not under.any():
        return [], []
    # Lamps hang in the middle of things, not in corners.
    under &= floor.clearance_m >= min(_FROM_WALLS_M, float(np.quantile(floor.clearance_m[under], 0.6)))
    covered = floor.points_m[under]
    ceiling = covered[:, 2] + floor.headroom_m[under]
    lights, panels = [], []
    for index in _spread(covered, _LAMP_SPACING_M):
        centre = np.array([covered[index, 0], covered[index, 1], ceiling[index] - 2 * _BESIDE_M])
        flux = _LAMP_EXITANCE_LM_M2 * _LAMP_SPACING_M**2 * white_at(_LAMP_K)
        down = np.array([0.0, 0.0, -1.0])
        lights.append(_square(centre - np.array([0, 0, _BESIDE_M]), down, flux, _LAMP_EDGE_M))
        half = _LAMP_EDGE_M / 2
        ring = np.array([[-half, -half, 0], [-half, half, 0], [half, half, 0], [half, -half, 0]])
        panels.append(Patch(centre + ring, np.array([[0, 1, 2], [0, 2, 3]]), -1, 0, np.tile(down, (4, 1))))
    return lights, panels


def panel_luminance_cd_m2() -> NDArray[np.float64]:
    """(3,) of placed lamps [cd/m2]."""
    flux = _LAMP_EXITANCE_LM_M2 * _LAMP_SPACING_M**2 * white_at(_LAMP_K)
    return np.asarray(flux / (math.pi * _LAMP_EDGE_M**2))


def strongest(lights: Sequence[Light], most: int = MOST_LIGHTS) -> list[Light]:
    if len(lights) <= most:
        return list(lights)
    power = np.array([float(photopic(light.flux_lm)) for light in lights])
    far = np.array([float(np.linalg.norm(light.position_m)) > SUN_DISTANCE_M / 2 for light in lights])
    order = np.argsort(np.where(far, np.inf, power), kind="stable")[::-1]
    kept = [lights[index] for index in order[:most]]
    near = [index for index in order if not far[index]]
    total, left = power[near].sum(), power[[index for index in order[:most] if not far[index]]].sum()
    if not left > 0:
        return kept
    factor = np.float32(total / left)
    return [
        light if far[index] else replace(light, flux_lm=light.flux_lm * factor)
        for light, index in zip(kept, order[:most], strict=True)
    ]


def _spread(points_m: NDArray[np.float64], spacing_m: float) -> list[int]:
    """Points so far apart, each next one the farthest from all before it."""
    first = int(np.argmin(((points_m - points_m.mean(axis=0)) ** 2).sum(axis=1)))
    chosen = [first]
    distance = np.linalg.norm(points_m - points_m[first], axis=1)
    while len(chosen) < MOST_LIGHTS and distance.max() >= spacing_m:
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.linalg.norm(points_m - points_m[chosen[-1]], axis=1))
    return chosen


def _rectangle(
    points_m: NDArray[np.float64],
    centre: NDArray[np.float64],
    normal: NDArray[np.float64],
    area_m2: float,
    flux_lm: NDArray[np.float64],
) -> Light:
    """A rectangle along the main axes of a flat piece, of its area."""
    flat = points_m - centre
    flat = flat - np.outer(flat @ normal, normal)
    _, axes = np.linalg.eigh(flat.T @ flat + 1e3 * np.outer(normal, normal))
    u, v = axes[:, 1], axes[:, 0]
    extent = np.array([np.ptp(flat @ u), np.ptp(flat @ v)])
    extent *= math.sqrt(area_m2 / max(float(extent.prod()), 1e-12))
    return Light(
        _f32(centre + _BESIDE_M * normal),
        _f32(flux_lm),
        normal=_f32(normal),
        half_u_m=_f32(u * extent[0] / 2),
        half_v_m=_f32(v * extent[1] / 2),
    )


def _square(
    position: NDArray[np.float64], normal: NDArray[np.float64], flux_lm: NDArray[np.float64], edge_m: float
) -> Light:
    helper = np.array([1.0, 0, 0]) if abs(normal[0]) < 0.9 else np.array([0, 1.0, 0])
    u = np.cross(normal, helper)
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    return Light(_f32(position), _f32(flux_lm), _f32(normal), _f32(u * edge_m / 2), _f32(v * edge_m / 2))


def _f32(values: NDArray[np.float64]) -> NDArray[np.float32]:
    return values.astype(np.float32)
