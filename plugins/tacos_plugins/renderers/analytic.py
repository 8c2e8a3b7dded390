"""Small ray caster without OpenGL, for tests and machines without it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_framework import (
    Camera,
    Capture,
    Episode,
    Exposure,
    Light,
    Material,
    Rig,
    Settings,
    View,
    World,
    setting,
)
from tacos_framework.camera import LINEAR_OF_SRGB_BYTE, pixel_rays, world_from_camera
from tacos_plugins.renderers.traced.moments import world_at

_RAYS_TIMES_TRIANGLES = 1 << 22  # pairs tested at once; bounds memory
_EDGE = -1e-9  # barycentric slack, so that no ray slips between two triangles


class AnalyticRenderer:
    """Casts one ray through each pixel centre against every triangle, in numpy.

    Geometry and units are those of `renderer.moderngl`. Surfaces are Lambertian and light casts no shadows;
    indirect light is `World.indirect_lux` where the world has it, and the light of its surroundings
    otherwise. There is no anti-aliasing and no motion blur. The cost is pixels times triangles: meant for low
    resolutions and small worlds. It casts the rays of any lens.

    Source: Moeller, T., and Trumbore, B. (1997). Fast, minimum storage ray/triangle intersection.
    """

    class Config(Settings):
        """Settings of `renderer.analytic`."""

        near_m: float = setting(0.05, help="Surfaces nearer than this are not seen.", unit="m", gt=0)

    draws_lenses = True

    def __init__(self, config: Config):
        self._config = config

    def capture(self, episode: Episode, *, rig: Rig, exposure: Exposure) -> Capture:
        """One view per camera of the rig for every frame of the batch; the exposure does not matter."""
        return Capture(episode, tuple(self._view(episode, camera) for camera in rig.cameras))

    def _view(self, episode: Episode, camera: Camera) -> View:
        poses = world_from_camera(episode.trajectory.at(episode.time_s), camera.agent_from_camera)
        shape = (len(poses), camera.height_px, camera.width_px)
        luminance = np.empty((*shape, 3), np.float32)
        depth = np.empty(shape, np.float32)
        object_id = np.empty(shape, np.int32)
        rays = pixel_rays(camera).reshape(-1, 3)
        surfaces = _Surfaces(episode.world)
        for frame, pose in enumerate(poses):
            if episode.movers:
                surfaces = _Surfaces(world_at(episode, float(episode.time_s[frame])))
            directions = rays @ pose[:3, :3].T  # of depth 1, so distance along them is depth
            found = first_hits(surfaces.corners_m, pose[:3, 3], directions, self._config.near_m)
            triangle, distance, weights = found
            seen = triangle >= 0
            colour = np.tile(episode.world.ambient_cd_m2, (len(rays), 1))
            colour[np.isnan(rays[:, 0])] = 0  # outside of the image circle
            colour[seen] = surfaces.luminance_cd_m2(triangle[seen], weights[seen])
            luminance[frame] = colour.reshape(luminance.shape[1:])
            depth[frame] = distance.reshape(depth.shape[1:])
            ids = np.zeros(len(rays), np.int32)
            ids[seen] = surfaces.object_id[triangle[seen]]
            object_id[frame] = ids.reshape(depth.shape[1:])
        return View(camera, poses, luminance, depth, object_id)


def first_hits(
    corners_m: NDArray[np.float64],
    origin_m: NDArray[np.float64],
    directions: NDArray[np.float64],
    near: float,
) -> tuple[NDArray[np.intp], NDArray[np.float64], NDArray[np.float64]]:
    """First hits of rays from one point.

    - `corners_m`: (T, 3, 3) corners of triangles [m].
    - `origin_m`: (3,) where the rays start [m].
    - `directions`: (N, 3) of any length [m].
    - `near`: least distance, in lengths of the direction [1].

    Returns:

    - `triangle`: (N,) index; -1 where nothing is met.
    - `distance`: (N,) in lengths of the direction; infinite where nothing is met [1].
    - `weights`: (N, 3) barycentric weights of the corners [1].
    """
    count = len(directions)
    nearest = np.full(count, -1, dtype=np.intp)
    distance = np.full(count, np.inf)
    weights = np.zeros((count, 3))
    if len(corners_m) == 0:
        return nearest, distance, weights
    first, second = corners_m[:, 1] - corners_m[:, 0], corners_m[:, 2] - corners_m[:, 0]
    to_origin = origin_m - corners_m[:, 0]
    # With one origin for all rays, each term is a product of the directions with one vector per triangle.
    across = np.cross(to_origin, first)
    to_determinant, to_u = np.cross(second, first), np.cross(second, to_origin)
    to_distance = np.einsum("tj,tj->t", second, across)
    step = max(_RAYS_TIMES_TRIANGLES // len(corners_m), 1)
    for start in range(0, count, step):
        part = slice(start, min(start + step, count))
        rays = directions[part]
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = 1 / (rays @ to_determinant.T)
            u = (rays @ to_u.T) * scale
            v = (rays @ across.T) * scale
            t = to_distance * scale
            inside = (u >= _EDGE) & (v >= _EDGE) & (u + v <= 1 - _EDGE) & (t >= near)
        t = np.where(inside, t, np.inf)
        best = t.argmin(axis=1)
        row = np.arange(len(rays))
        met = np.isfinite(t[row, best])
        nearest[part] = np.where(met, best, -1)
        distance[part] = t[row, best]
        weights[part] = np.column_stack([1 - u[row, best] - v[row, best], u[row, best], v[row, best]])
    return nearest, distance, weights


class _Surfaces:
    """The triangles of a world and what is needed to shade them."""

    def __init__(self, world: World):
        self._world = world
        parts = world.parts
        firsts = np.concatenate([[0], np.cumsum([len(part.vertices_m) for part in parts])]).astype(np.int64)
        counts = np.array([len(part.triangles) for part in parts], np.intp)
        self._triangles = np.concatenate(
            [np.zeros((0, 3), np.int64)] + [p.triangles + f for p, f in zip(parts, firsts, strict=False)]
        )
        self._vertices = np.concatenate([np.zeros((0, 3))] + [part.vertices_m for part in parts])
        self._normals = np.concatenate([np.zeros((0, 3))] + [part.normals for part in parts])
        self._uv_m = np.concatenate([np.zeros((0, 2))] + [part.uv_m for part in parts])
        self._material = np.repeat(np.array([part.material for part in parts], np.intp), counts)
        self._indirect = (
            None if world.indirect_lux is None else np.concatenate([np.zeros((0, 3)), *world.indirect_lux])
        )
        self.object_id = np.repeat(np.array([part.object_id for part in parts], np.int32), counts)
        self.corners_m = self._vertices[self._triangles].astype(np.float64)

    def luminance_cd_m2(
        self, triangle: NDArray[np.intp], weights: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """(N, 3) luminance of points on triangles [cd/m2]."""
        corners = self._triangles[triangle]

        def interpolated(values: NDArray[np.floating]) -> NDArray[np.float64]:
            return np.einsum("nc,ncj->nj", weights, values[corners])

        point, normal = interpolated(self._vertices), interpolated(self._normals)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        if self._indirect is None:
            irradiance = np.tile(np.pi * self._world.ambient_cd_m2.astype(np.float64), (len(point), 1))
        else:
            irradiance = interpolated(self._indirect)
        for light in self._world.lights:
            irradiance += irradiance_lux(light, point, normal)
        luminance = np.empty_like(irradiance)
        uv_m, material_of = interpolated(self._uv_m), self._material[triangle]
        for index in np.unique(material_of):
            here, material = material_of == index, self._world.materials[index]
            reflected = reflectance(material, uv_m[here]) * irradiance[here] / np.pi
            luminance[here] = reflected + material.emission_cd_m2
        return luminance


def irradiance_lux(
    light: Light, point_m: NDArray[np.float64], normal: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(N, 3) irradiance of points by an area light without shadows [lux].

    A rectangle is integrated with Gauss-Legendre quadrature, a sphere is taken as its centre.
    """
    total = np.zeros(len(point_m))
    nodes, shares = np.polynomial.legendre.leggauss(3 if light.normal is not None else 1)
    for a, share_a in zip(nodes, shares, strict=True):
        for b, share_b in zip(nodes, shares, strict=True):
            to = light.position_m + a * light.half_u_m + b * light.half_v_m - point_m
            distance = np.maximum(np.linalg.norm(to, axis=1), 1e-6)
            arriving = np.maximum(np.einsum("nj,nj->n", to, normal), 0) / distance**3
            if light.normal is None:
                total += share_a * share_b / 4 * arriving / (4 * np.pi)
            else:
                leaving = np.maximum(-(to @ light.normal), 0) / distance
                total += share_a * share_b / 4 * arriving * leaving / np.pi
    return total[:, None] * light.flux_lm.astype(np.float64)


def reflectance(material: Material, uv_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) linear reflectance of a material at texture coordinates in metres, nearest texel [1]."""
    base = np.tile(material.base_colour.astype(np.float64), (len(uv_m), 1))
    if material.texture is None:
        return base
    edge = len(material.texture)
    column, row = (np.floor(uv_m / material.texture_size_m * edge).astype(np.int64) % edge).T
    return base * LINEAR_OF_SRGB_BYTE[material.texture[row, column]]
