"""Depth and object ids behind traced pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, World
from tacos_framework.camera import pixel_rays
from tacos_plugins.lighting.occlusion import Occlusion


class TracedTruth:
    """Depth and ids of a world, by one ray a pixel: a mean over the pixel would be neither."""

    def __init__(self, world: World) -> None:
        self._occlusion = Occlusion(world)
        counts = np.array([len(part.triangles) for part in world.parts], np.intp)
        self._object_of_triangle = np.repeat(
            np.array([part.object_id for part in world.parts], np.int32), counts
        )

    def seen(
        self, camera: Camera, world_from_camera: NDArray[np.float64], near_m: float
    ) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """(H, W) depth [m] and (H, W) object ids at pixel centres."""
        directions = pixel_rays(camera).reshape(-1, 3) @ world_from_camera[:3, :3].T  # of depth 1
        origins = (world_from_camera[:3, 3] + near_m * directions).astype(np.float32)
        hits = self._occlusion.first_hits(origins, directions.astype(np.float32))
        met = hits.triangle >= 0
        object_id = np.zeros(len(met), np.int32)
        object_id[met] = self._object_of_triangle[hits.triangle[met]]
        shape = (camera.height_px, camera.width_px)
        return (hits.distance_m + np.float32(near_m)).reshape(shape), object_id.reshape(shape)
