"""Light that is the same everywhere, on exact geometry."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray
from tacos_framework import Camera, Capture, Episode, Rig, Settings, View, World, setting
from tacos_framework.camera import pixel_rays, world_from_camera
from trimesh.ray.ray_pyembree import RayMeshIntersector


class IntegratingSphere:
    """Spreads the flux of all lamps evenly over all surfaces, as in an integrating sphere:

        E = flux / (area (1 - mean reflectance))

    No shadows and no shading, so it is quick to reason about, and depth and ids are exact.

    Source: Ulbricht 1900, "Die Bestimmung der mittleren raeumlichen Lichtintensitaet durch nur eine Messung".
    """

    class Config(Settings):
        near_m: float = setting(0.01, help="Surfaces nearer than this are not seen.", unit="m", gt=0)

    def __init__(self, config: Config) -> None:
        self.config = config

    def capture(self, episode: Episode, *, rig: Rig) -> Capture:
        """One view per camera for every frame of the batch."""
        scene = _LitScene(episode.world)
        return Capture(episode, tuple(self._view(episode, camera, scene) for camera in rig.cameras))

    def _view(self, episode: Episode, camera: Camera, scene: _LitScene) -> View:
        poses = world_from_camera(episode.trajectory.at(episode.time_s), camera.agent_from_camera)
        size = (len(poses), camera.height_px, camera.width_px)
        luminance = np.empty((*size, 3), np.float32)
        depth = np.empty(size, np.float32)
        ids = np.empty(size, np.int32)
        rays = pixel_rays(camera).reshape(-1, 3)  # of depth 1, so distance along them is depth
        for frame, pose in enumerate(poses):
            found = scene.look(pose[:3, 3], rays @ pose[:3, :3].T, self.config.near_m)
            luminance[frame], depth[frame], ids[frame] = (
                values.reshape((*size[1:], *values.shape[1:])) for values in found
            )
        return View(camera, poses, luminance, depth, ids)


class _LitScene:
    """The triangles of a world, the luminance of each, and a way to find what rays meet."""

    def __init__(self, world: World) -> None:
        counts = [len(part.vertices_m) for part in world.parts]
        firsts = np.cumsum([0, *counts[:-1]])
        faces = [part.triangles + first for part, first in zip(world.parts, firsts, strict=True)]
        vertices = np.concatenate([part.vertices_m for part in world.parts]).astype(np.float64)
        self._mesh = trimesh.Trimesh(vertices, np.concatenate(faces), process=False)
        self._rays = RayMeshIntersector(self._mesh)
        per_part = [len(part.triangles) for part in world.parts]
        material = np.repeat([part.material for part in world.parts], per_part)
        self._ids = np.repeat([part.object_id for part in world.parts], per_part)
        self._background = world.ambient_cd_m2
        reflectance = np.array([material.base_colour for material in world.materials])[material]
        emission = np.array([material.emission_cd_m2 for material in world.materials])[material]
        self._luminance_cd_m2 = emission + reflectance * self._illuminance_lux(world, reflectance) / np.pi

    def _illuminance_lux(self, world: World, reflectance: NDArray[np.float32]) -> NDArray[np.float64]:
        area_m2 = self._mesh.area_faces
        flux_lm = np.sum([light.flux_lm for light in world.lights], axis=0, initial=0.0)
        mean_reflectance = (reflectance * area_m2[:, None]).sum(axis=0) / area_m2.sum()
        return np.asarray(flux_lm / (area_m2.sum() * np.maximum(1 - mean_reflectance, 0.01)))

    def look(
        self, origin_m: NDArray[np.float64], rays: NDArray[np.float64], near_m: float
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.int32]]:
        """Luminance (N, 3) [cd/m2], depth (N,) [m] and object (N,) that rays of depth 1 meet first."""
        triangle = self._rays.intersects_first(origin_m + rays * near_m, rays)
        hit = triangle >= 0
        luminance = np.tile(self._background, (len(rays), 1)).astype(np.float32)
        depth, ids = np.full(len(rays), np.inf, np.float32), np.zeros(len(rays), np.int32)
        met = triangle[hit]
        normal = self._mesh.face_normals[met]
        to_plane = self._mesh.triangles[met, 0] - origin_m
        depth[hit] = np.einsum("nj,nj->n", to_plane, normal) / np.einsum("nj,nj->n", rays[hit], normal)
        luminance[hit], ids[hit] = self._luminance_cd_m2[met], self._ids[met]
        return luminance, depth, ids
