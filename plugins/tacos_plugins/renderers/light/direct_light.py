"""Direct light of area lights with soft shadows, at any points, once per world.

The world and its lights stand still, so what lights a surface does not depend on the camera: it is
computed here once, with as many shadow rays as a smooth penumbra needs, and only looked up per frame.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Light
from tacos_plugins.renderers.light.rays import RayTracer

LEAST_SHARE = 0.003
"""Lights that would give a point a smaller share of its unshadowed light are left out there [1]."""

_BLOCK = 1 << 16
_PROBES = 2  # per edge of a light: if these agree the point is taken as fully lit or fully dark
_PENUMBRA = 8  # per edge of a light, for points in the penumbra
_STOP_SHORT = 0.995  # of the way to the light, so that a lamp's own housing does not shade it


@dataclass(frozen=True, eq=False)
class LightAtPoints:
    irradiance_lux: NDArray[np.float32]
    """(N, 3) float32 [lux]."""
    towards: NDArray[np.float32]
    """(N, 3) float32 mean direction it comes from, weighted by irradiance on a plane that faces each
    direction; its length is 1 for a single point-like source and 0 for light from everywhere alike [1].
    """
    unshadowed_lux: NDArray[np.float32]
    """(N,) float32 mean channel of the irradiance there would be without shadows [lux]."""


def direct_light(
    lights: Sequence[Light], point_m: NDArray[np.float32], normal: NDArray[np.float32], tracer: RayTracer
) -> LightAtPoints:
    """Direct irradiance at points of surfaces.

    `point_m`, `normal`: (N, 3) points, slightly above their surface, and unit normals [m, 1].
    """
    count = len(point_m)
    irradiance = np.zeros((count, 3), np.float32)
    towards = np.zeros((count, 3), np.float32)
    unshadowed_lux = np.zeros(count, np.float32)
    for block in _blocks(count):
        points, normals = point_m[block], normal[block]
        unshadowed = np.zeros((len(points), len(lights)), np.float32)
        for index, light in enumerate(lights):
            unshadowed[:, index] = _irradiance(light, points, normals)
        relevant = unshadowed > LEAST_SHARE * unshadowed.sum(axis=1, keepdims=True)
        visible = np.zeros_like(unshadowed)
        for index, light in enumerate(lights):
            who = np.flatnonzero(relevant[:, index])
            visible[who, index] = _visible_share(light, points[who], tracer)
        arriving = unshadowed * visible
        flux = np.array([light.flux_lm for light in lights], np.float32).reshape(-1, 3)
        colour = flux / np.maximum(flux.mean(axis=1, keepdims=True), 1e-20)
        irradiance[block] = arriving @ colour
        towards[block] = _mean_direction(lights, points, normals, arriving)
        unshadowed_lux[block] = unshadowed.sum(axis=1)
    return LightAtPoints(irradiance, towards, unshadowed_lux)


def _blocks(count: int) -> Iterator[slice]:
    return (slice(start, min(start + _BLOCK, count)) for start in range(0, count, _BLOCK))


def _irradiance(
    light: Light, point_m: NDArray[np.float32], normal: NDArray[np.float32]
) -> NDArray[np.float32]:
    """(N,) mean channel of the irradiance without shadows [lux]."""
    flux = float(light.flux_lm.mean())
    total = np.zeros(len(point_m), np.float32)
    for offset, weight in _quadrature(light):
        to = (light.position_m + offset).astype(np.float32) - point_m
        squared = np.maximum(np.einsum("ij,ij->i", to, to), 1e-6)
        cosine = np.maximum(np.einsum("ij,ij->i", to, normal), 0)  # times the distance
        if light.normal is None:
            total += weight * flux / (4 * np.pi) * cosine / squared**1.5
        else:
            leaving = np.maximum(-(to @ light.normal), 0)  # times the distance
            # Lambertian: intensity flux / pi * cos(leaving)
            total += weight * flux / np.pi * leaving * cosine / squared**2
    return total


def _quadrature(light: Light) -> list[tuple[NDArray[np.float32], float]]:
    """Points on the light relative to its centre, and their weights (Gauss-Legendre on rectangles)."""
    if light.normal is None:
        return [(np.zeros(3, np.float32), 1.0)]
    nodes, weights = np.polynomial.legendre.leggauss(3)
    return [
        ((a * light.half_u_m + b * light.half_v_m).astype(np.float32), float(wa * wb / 4))
        for a, wa in zip(nodes, weights, strict=True)
        for b, wb in zip(nodes, weights, strict=True)
    ]


def _visible_share(light: Light, point_m: NDArray[np.float32], tracer: RayTracer) -> NDArray[np.float32]:
    """(N,) share of the light that is seen from each point [1]."""
    share = _traced_share(light, point_m, _PROBES, tracer)
    penumbra = np.flatnonzero((share > 0) & (share < 1))
    share[penumbra] = _traced_share(light, point_m[penumbra], _PENUMBRA, tracer)
    return share


def _traced_share(
    light: Light, point_m: NDArray[np.float32], per_edge: int, tracer: RayTracer
) -> NDArray[np.float32]:
    on_light = light.position_m + _grid_on(light, per_edge)  # (S, 3)
    origin = np.repeat(point_m, len(on_light), axis=0)
    target = np.tile(on_light.astype(np.float32), (len(point_m), 1))
    blocked = tracer.blocked(origin, (target - origin) * np.float32(_STOP_SHORT))
    return 1 - blocked.reshape(len(point_m), len(on_light)).mean(axis=1, dtype=np.float32)


def _grid_on(light: Light, per_edge: int) -> NDArray[np.float32]:
    """(per_edge^2, 3) evenly spread points of the light relative to its centre [m]."""
    if light.normal is None:
        # A Fibonacci sphere, its points as even as can be.
        count = per_edge * per_edge
        z = 1 - (2 * np.arange(count) + 1) / count
        turn = np.pi * (3 - np.sqrt(5)) * np.arange(count)
        ring = np.sqrt(1 - z * z)
        return (light.radius_m * np.column_stack([ring * np.cos(turn), ring * np.sin(turn), z])).astype(
            np.float32
        )
    place = (2 * np.arange(per_edge) + 1) / per_edge - 1
    if per_edge == _PROBES:
        place = place * 1.8  # near the corners: a penumbra must not slip between the probes
    a, b = np.meshgrid(place, place, indexing="ij")
    return (a.reshape(-1, 1) * light.half_u_m + b.reshape(-1, 1) * light.half_v_m).astype(np.float32)


def _mean_direction(
    lights: Sequence[Light],
    point_m: NDArray[np.float32],
    normal: NDArray[np.float32],
    arriving: NDArray[np.float32],
) -> NDArray[np.float32]:
    """(N, 3) sum over lights of irradiance / cosine times direction, over the same sum of lengths [1]."""
    total = np.zeros_like(point_m)
    length = np.zeros(len(point_m), np.float32)
    for index, light in enumerate(lights):
        to = (light.position_m - point_m).astype(np.float32)
        to /= np.maximum(np.linalg.norm(to, axis=1, keepdims=True), 1e-6)
        facing = arriving[:, index] / np.maximum(np.einsum("ij,ij->i", to, normal), 0.05)
        total += facing[:, None] * to
        length += facing
    return (total / np.maximum(length, 1e-20)[:, None]).astype(np.float32)
