"""Light after reflections: gathered once with rays, then bounced as sparse-matrix products."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, get_index_dtype

from tacos_framework import World
from tacos_plugins.coincident_faces import corners_behind, other_sides
from tacos_plugins.lighting.direct import SURFACE_OFFSET_M, direct_irradiance
from tacos_plugins.lighting.occlusion import Occlusion, WorldHits
from tacos_plugins.lighting.refinement import refined
from tacos_plugins.lighting.reflectance import mean_reflectances
from tacos_plugins.lighting.sites import Sites, merge_vertices

LONGEST_EDGE_M = 0.8
"""Larger triangles are split, where nothing else is asked for [m]."""


class LightTransport:
    """Light in one world, by gather radiosity.

    Surfaces are taken as Lambertian. From every *site* (vertices that share place, normal and material) a
    fixed fan of cosine-distributed rays is traced once. With F the fraction of light that reaches a site from
    each other one, r the reflectance and D the direct irradiance, the indirect irradiance E is the limit of

        E <- F (r * (D + E)) + F0 * pi * ambient                                             (1)

    All sites use the same fan relative to their normal: its error then varies as slowly as the light itself,
    where random fans would speckle.

    - `world`: the world; its `indirect_lux` is not used.
    - `merge_m`: vertices of one material closer than this, with similar normals, share a site [m].
    - `bounces`: number of iterations of (1); fewer where the light has converged.
    - `longest_edge_m`: larger triangles are split: light is interpolated between their corners [m].

    Source: Cohen, M. F., and Wallace, J. R. (1993). Radiosity and Realistic Image Synthesis.
    """

    def __init__(
        self,
        world: World,
        *,
        rays: int = 64,
        merge_m: float = 0.08,
        bounces: int = 12,
        longest_edge_m: float = LONGEST_EDGE_M,
    ) -> None:
        self._world = world
        self._surfaces = refined(world, longest_edge_m)
        self._fan = cosine_fan(rays)
        self._merge_m = merge_m
        self._bounces = bounces
        self._ambient_lux = math.pi * world.ambient_cd_m2.astype(np.float64)

    @cached_property
    def occlusion(self) -> Occlusion:
        """The world's triangles, the large ones split."""
        return Occlusion(self._surfaces)

    @cached_property
    def _sites(self) -> Sites:
        return merge_vertices(self._surfaces, self.occlusion, self._merge_m)

    @cached_property
    def _radiosity_lux(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(sites, 3) indirect irradiance, and exitance (reflected light, direct and indirect)."""
        sites = self._sites
        reflectance = mean_reflectances(self._world.materials)[sites.material]
        gather, escaped = self._gather(sites.points_m, sites.normals)
        direct = direct_irradiance(self.occlusion, self._world.lights, sites.points_m, sites.normals)
        ambient = escaped[:, None] * self._ambient_lux
        indirect = ambient
        for _ in range(self._bounces):
            bounced = (
                _product(gather, (reflectance * (direct + indirect)).astype(np.float32)) + ambient
            )  # (1)
            settled = np.abs(bounced - indirect).sum() <= 1e-3 * bounced.sum()
            indirect = bounced
            if settled:
                break
        return indirect, reflectance * (direct + indirect)

    def _gather(
        self, points_m: NDArray[np.float32], normals: NDArray[np.float32]
    ) -> tuple[csr_array, NDArray[np.float64]]:
        """The matrix F (points, sites), and the share of rays that left the world (points,)."""
        rays = len(self._fan)
        if not len(self._sites.points_m):
            return csr_array((len(points_m), 0)), np.ones(len(points_m))
        directions = aligned_with(self._fan, normals)
        starts = np.repeat(points_m + SURFACE_OFFSET_M * normals, rays, axis=0)
        hits = self.occlusion.first_hits(starts, directions.reshape(-1, 3))
        corners = self._sites.of_vertex[self._seen_corners(hits, directions.reshape(-1, 3))]
        # Indices of 32 bits where they will do: half the memory to go through in each product.
        row_starts = np.arange(0, corners.size + 1, 3 * rays, dtype=get_index_dtype(maxval=corners.size))
        gather = csr_array(
            (hits.barycentric.reshape(-1) / np.float32(rays), corners.reshape(-1), row_starts),
            shape=(len(points_m), len(self._sites.points_m)),
        )
        escaped = (hits.triangle < 0).reshape(-1, rays).mean(axis=1)
        return gather, escaped

    @cached_property
    def _behind(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Of each triangle its other side, and that side's vertices at its corners."""
        vertices, triangles = self.occlusion.vertices_m, self.occlusion.triangles
        other = other_sides(vertices[triangles])
        return other, corners_behind(vertices, triangles, other)

    def _seen_corners(self, hits: WorldHits, directions: NDArray[np.float32]) -> NDArray[np.integer]:
        """(N, 3) vertices at the corners of what rays meet: of a sheet, those of the side they come from."""
        met = np.maximum(hits.triangle, 0)
        corners = self.occlusion.triangles[met]
        other, behind = self._behind
        unsure = np.flatnonzero((hits.triangle >= 0) & (other[met] >= 0))
        if not len(unsure):
            return corners
        a, b, c = (self.occlusion.vertices_m[corners[unsure, corner]] for corner in range(3))
        from_behind = np.einsum("ij,ij->i", np.cross(b - a, c - a), directions[unsure]) > 0
        corners[unsure[from_behind]] = behind[met[unsure[from_behind]]]
        return corners

    def direct_lux(self, points_m: NDArray[np.float32], normals: NDArray[np.float32]) -> NDArray[np.float64]:
        """(N, 3) irradiance straight from the lights on surface elements at (N, 3) points [lux]."""
        return direct_irradiance(self.occlusion, self._world.lights, points_m, normals)

    def indirect_lux(
        self, points_m: NDArray[np.float32], normals: NDArray[np.float32]
    ) -> NDArray[np.float64]:
        """(N, 3) irradiance after at least one reflection (or from beyond the world) [lux]."""
        gather, escaped = self._gather(points_m, normals)
        return _product(gather, self._radiosity_lux[1]) + escaped[:, None] * self._ambient_lux

    def vertex_indirect_lux(self) -> tuple[NDArray[np.float32], ...]:
        """One (V, 3) array a part: indirect irradiance at its vertices, as `World.indirect_lux` [lux]."""
        of_vertex = self._radiosity_lux[0][self._sites.of_vertex].astype(np.float32)
        ends = np.cumsum([len(part.vertices_m) for part in self._surfaces.parts])
        per_part = np.split(of_vertex, ends[:-1]) if len(ends) else []
        return tuple(
            lux[: len(part.vertices_m)] for lux, part in zip(per_part, self._world.parts, strict=True)
        )


def _product(matrix: csr_array, values: NDArray[np.floating]) -> NDArray[np.floating]:
    """(N, 3) product with (S, 3) values, one channel at a time: scipy is slow at three side by side."""
    return np.stack([matrix @ channel for channel in np.ascontiguousarray(values.T)], axis=1)


def bake_indirect(
    world: World, *, rays: int = 64, merge_m: float = 0.08, bounces: int = 12
) -> tuple[NDArray[np.float32], ...]:
    """Indirect irradiance at every vertex: one (V, 3) float32 array per part [lux].

    See `LightTransport` for the model and the parameters.
    """
    return LightTransport(world, rays=rays, merge_m=merge_m, bounces=bounces).vertex_indirect_lux()


def irradiance_at(
    world: World, points_m: NDArray[np.float32], normals: NDArray[np.float32], *, rays: int = 64
) -> NDArray[np.float64]:
    """(N, 3) irradiance, direct and indirect, at (N, 3) points of surfaces with unit normals [lux]."""
    transport = LightTransport(world, rays=rays)
    return transport.direct_lux(points_m, normals) + transport.indirect_lux(points_m, normals)


def cosine_fan(rays: int) -> NDArray[np.float32]:
    """(rays, 3) unit vectors about z, with density proportional to the cosine of their angle to z.

    A Fibonacci spiral on the unit disc, lifted to the hemisphere (Malley's method).
    """
    index = np.arange(rays)
    radius = np.sqrt((index + 0.5) / rays)
    angle = index * math.pi * (3 - math.sqrt(5))
    height = np.sqrt(np.clip(1 - radius**2, 0, None))
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1).astype(np.float32)


def aligned_with(fan: NDArray[np.float32], normals: NDArray[np.float32]) -> NDArray[np.float32]:
    """(N, rays, 3) fans turned so that their z lies along each of (N, 3) unit normals.

    The tangent frame is Duff et al.'s (2017), continuous but for the sign of z.
    """
    x, y, z = normals.T
    sign = np.where(z >= 0, 1.0, -1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    tangent = np.stack([1 + sign * x * x * a, sign * b, -sign * x], axis=1)
    bitangent = np.stack([b, sign + y * y * a, -y], axis=1)
    frame = np.stack([tangent, bitangent, normals], axis=1).astype(np.float32)
    return np.asarray(fan @ frame, dtype=np.float32)
