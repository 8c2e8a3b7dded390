"""Light that reaches points straight from the sources."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Light
from tacos_plugins.lighting.occlusion import Occlusion

Samples = Iterator[tuple[NDArray[np.intp], NDArray[np.float32], NDArray[np.float64]]]
"""For each part of a light: the L points that face it, (L, 3) targets on it [m], and the irradiance of each
point per flux (L,) [1/m2]."""

SURFACE_OFFSET_M = 1e-3
"""Rays start this far off a surface, so that it does not shadow itself [m]."""


def direct_irradiance(
    occlusion: Occlusion,
    lights: Sequence[Light],
    points_m: NDArray[np.float32],
    normals: NDArray[np.float32],
    *,
    samples_per_edge: int = 3,
) -> NDArray[np.float64]:
    """Irradiance straight from the lights, with soft shadows.

    `points_m`, `normals`: (N, 3) points and the unit normals of the surface elements there [m].
    `samples_per_edge`: each light is sampled at so many by so many points.

    Returns: (N, 3) irradiance per channel [lux].
    """
    total = np.zeros((len(points_m), 3))
    starts = (points_m + SURFACE_OFFSET_M * normals).astype(np.float32)
    for light in lights:
        sample = _sphere_samples if light.normal is None else _rectangle_samples
        weight_sum = np.zeros(len(points_m))
        for facing, targets, weight_per_m2 in sample(light, points_m, normals, samples_per_edge):
            seen = occlusion.visible(starts[facing], targets)
            weight_sum[facing[seen]] += weight_per_m2[seen]
        total += weight_sum[:, None] * light.flux_lm.astype(np.float64)
    return total


def _quadrature(count: int) -> list[tuple[float, float, float]]:
    """(u, v, weight) of count x count Gauss-Legendre nodes of the square -1..1; weights add up to 1."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return [
        (float(u), float(v), float(a * b) / 4)
        for u, a in zip(nodes, weights, strict=True)
        for v, b in zip(nodes, weights, strict=True)
    ]


def _cells(count: int) -> list[tuple[float, float]]:
    """Centres of count x count cells of the square -1..1 that lie in the unit disc."""
    steps = (np.arange(count) * 2 + 1) / count - 1
    return [(float(u), float(v)) for u in steps for v in steps if u * u + v * v <= 1.0]


def _rectangle_samples(
    light: Light, points_m: NDArray[np.float32], normals: NDArray[np.float32], samples_per_edge: int
) -> Samples:
    """The parts of a rectangle.

    A Lambertian emitter of flux F and area A has luminance F / (pi A); a part dA of it gives
    ``dE = F / (pi A) * cos_emitter * cos_receiver / distance^2 * dA``.
    """
    for u, v, share in _quadrature(samples_per_edge):
        target = light.position_m + u * light.half_u_m + v * light.half_v_m
        to_light = target - points_m
        squared = np.maximum(np.einsum("ij,ij->i", to_light, to_light), 1e-8)
        receiver = np.einsum("ij,ij->i", to_light, normals)
        emitter = -(to_light @ np.asarray(light.normal))
        weight = np.clip(receiver, 0, None) * np.clip(emitter, 0, None) / squared**2
        facing = np.flatnonzero(weight > 0)
        yield facing, np.broadcast_to(target, (len(facing), 3)), weight[facing] * share / math.pi


def _sphere_samples(
    light: Light, points_m: NDArray[np.float32], normals: NDArray[np.float32], samples_per_edge: int
) -> Samples:
    """The parts of a sphere.

    A sphere shines like a point of intensity F / (4 pi) seen from outside. Soft shadows come from rays to
    a disc through the centre that faces the point; they end where they enter the sphere.
    """
    to_centre = light.position_m - points_m
    distance = np.maximum(np.linalg.norm(to_centre, axis=1, keepdims=True), 1e-6)
    forward = to_centre / distance
    cosine = np.einsum("ij,ij->i", forward, normals)
    facing = np.flatnonzero(cosine > 0)
    points_m, distance, forward = points_m[facing], distance[facing], forward[facing]
    helper = np.where(np.abs(forward[:, 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    right = np.cross(helper, forward)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    up = np.cross(forward, right)
    radius = light.radius_m
    beyond = np.maximum(distance[:, 0], radius)  # inside the sphere, as on its surface
    weight = cosine[facing] / (4 * math.pi * beyond**2)
    cells = _cells(samples_per_edge)
    for u, v in cells:
        on_disc = light.position_m + 0.9 * radius * (u * right + v * up)
        sagitta = 1.02 * radius * math.sqrt(1 - 0.81 * (u * u + v * v))
        reach = np.maximum(1 - sagitta / distance, 0)
        targets = points_m + (on_disc - points_m) * reach
        yield facing, targets.astype(np.float32), weight / len(cells)
