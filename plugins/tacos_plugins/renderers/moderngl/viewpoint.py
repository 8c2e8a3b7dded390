"""A camera at a place, for what draws and what is drawn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera
from tacos_framework.camera import invert_pose
from tacos_plugins.renderers.moderngl.projection import projection_matrix


@dataclass(frozen=True, eq=False)
class Viewpoint:
    """A camera at a place: its pose both ways, and the projection of the world into its clip space.

    Inverse depth becomes a depth of OpenGL's window by constant and slope in `window_of_inverse` [1, m].
    """

    camera: Camera
    world_from_camera: NDArray[np.float64]
    camera_from_world: NDArray[np.float64]
    clip_from_world: NDArray[np.float64]
    near_m: float
    window_of_inverse: tuple[float, float]

    def onto(self, moved: NDArray[np.float64]) -> Viewpoint:
        """The view from which a thing at rest looks as it does from here once (4, 4) `moved` [m]."""
        return Viewpoint(
            camera=self.camera,
            world_from_camera=invert_pose(moved) @ self.world_from_camera,
            camera_from_world=self.camera_from_world @ moved,
            clip_from_world=self.clip_from_world @ moved,
            near_m=self.near_m,
            window_of_inverse=self.window_of_inverse,
        )

    @property
    def eye_m(self) -> NDArray[np.float64]:
        """(3,) optical centre [m]."""
        return self.world_from_camera[:3, 3]

    @property
    def pixel_from_world(self) -> NDArray[np.float64]:
        """(3, 4) from the world [m] to homogeneous pixels, their centres integers; last is depth [m]."""
        (cx, cy), focal = self.camera.centre_px, self.camera.focal_length_px
        pixel_from_camera = np.array([[focal, 0.0, cx], [0.0, focal, cy], [0.0, 0.0, 1.0]])
        return pixel_from_camera @ self.camera_from_world[:3]

    @property
    def pixel_rays(self) -> NDArray[np.float64]:
        """(3, 3) change of a pixel's ray along columns and rows, and ray of pixel (0, 0), of depth 1."""
        (cx, cy), focal = self.camera.centre_px, self.camera.focal_length_px
        x, y, z = self.world_from_camera[:3, :3].T
        return np.stack([x / focal, y / focal, z - (cx * x + cy * y) / focal])


def viewpoint(
    camera: Camera, world_from_camera: NDArray[np.float64], near_m: float, far_m: float
) -> Viewpoint:
    """A camera at a pose, that sees what lies between two depths."""
    far_m = max(far_m, 2 * near_m)
    camera_from_world = invert_pose(world_from_camera)
    return Viewpoint(
        camera=camera,
        world_from_camera=world_from_camera,
        camera_from_world=camera_from_world,
        clip_from_world=projection_matrix(camera, near_m, far_m) @ camera_from_world,
        near_m=near_m,
        window_of_inverse=(far_m / (far_m - near_m), -far_m * near_m / (far_m - near_m)),
    )
