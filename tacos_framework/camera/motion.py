"""Motion of the image when the camera moves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera.geometry import depth_of, invert_pose, world_from_camera
from tacos_framework.camera.projection import pixels_of_rays, rays_of_pixels
from tacos_framework.values import Episode, ImageGeometry, Trajectory, View

Places = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Columns and rows of the image [px]."""

HALF_STEP_S = 0.5e-3
"""Motion is the difference of poses this long before and after a moment [s]."""


def inverse_depth(depth_m: NDArray[np.floating]) -> NDArray[np.float64]:
    """One over depth, 0 where nothing is [1/m]."""
    return 1.0 / np.asarray(depth_m, dtype=np.float64)


def reprojected(
    x_px: NDArray[np.floating],
    y_px: NDArray[np.floating],
    inverse_depth: NDArray[np.floating],
    geometry: ImageGeometry,
    other_from_camera: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Places at which another camera of the same kind sees the things this one sees.

    - `x_px`, `y_px`: places in the image of this camera [px].
    - `inverse_depth`: one over the depth of what is seen there [1/m].
    - `other_from_camera`: (4, 4) rigid transform from this camera's frame to the other's, or (..., 4, 4) one
      for each place [m].

    Returns:

    - `x_px`, `y_px`: places in the other's image; where a fisheye images nothing, the same places [px].
    - `scale`: depth of each point in the other camera over its depth in this one [1].

    A camera a step of 1 m ahead sees what is 2 m away twice as far from its centre:

    >>> geometry = ImageGeometry(5, 5, focal_length_px=4.0, centre_px=(2.0, 2.0), pixel_um=3)
    >>> ahead = np.eye(4)
    >>> ahead[2, 3] = -1.0
    >>> x, y, scale = reprojected(np.array(3.0), np.array(2.0), np.array(0.5), geometry, ahead)
    >>> x.item(), y.item(), scale.item()
    (4.0, 2.0, 0.5)
    """
    if not geometry.lens.is_pinhole:
        return _reprojected_by_rays(x_px, y_px, inverse_depth, geometry, other_from_camera)
    cx, cy = geometry.centre_px
    f = geometry.focal_length_px
    x, y, near = np.broadcast_arrays((x_px - cx) / f, (y_px - cy) / f, inverse_depth)
    points = (x, y, np.ones_like(x), near)  # over their depth
    seen = [sum(other_from_camera[..., i, j] * points[j] for j in range(4)) for i in range(3)]
    depth_ratio = np.maximum(seen[2], 1e-6)  # what comes to lie behind the camera leaves the image
    return seen[0] / depth_ratio * f + cx, seen[1] / depth_ratio * f + cy, depth_ratio


def _reprojected_by_rays(
    x_px: NDArray[np.floating],
    y_px: NDArray[np.floating],
    inverse_depth: NDArray[np.floating],
    geometry: ImageGeometry,
    other_from_camera: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """`reprojected` through any lens."""
    x, y, near = np.broadcast_arrays(x_px, y_px, inverse_depth)
    places = np.stack([x, y], axis=-1).astype(np.float64)
    rays = rays_of_pixels(places, geometry)
    points = rays / depth_of(rays, geometry)[..., None]  # over their depth
    turned = np.einsum("...ij,...j->...i", other_from_camera[..., :3, :3], points)
    seen = turned + near[..., None] * other_from_camera[..., :3, 3]
    there = pixels_of_rays(seen, geometry)
    there = np.where(np.isnan(there), places, there)
    scale = np.maximum(np.nan_to_num(depth_of(seen, geometry), nan=1.0), 1e-6)
    return there[..., 0], there[..., 1], scale


@dataclass(frozen=True, eq=False)
class FrameMotion:
    """Motion over the image of the things in one frame: by the agent's way, and by their own."""

    geometry: ImageGeometry
    time_s: float
    """The frame's moment: the middle of its exposure, of its middle row where the shutter is rolling [s]."""
    agent: Trajectory
    agent_from_camera: NDArray[np.float64]
    """(4, 4) the camera on the agent [m]."""
    movers: Mapping[int, Trajectory]
    """The ways of what moves by itself, by object id."""

    @classmethod
    def of(cls, view: View, episode: Episode) -> FrameMotion:
        """Of a view of the one frame of an episode."""
        return cls(
            ImageGeometry.of_camera(view.camera),
            float(episode.time_s[0]),
            episode.trajectory.continued,
            view.camera.agent_from_camera,
            {mover.object_id: mover.trajectory.continued for mover in episode.movers},
        )

    def shown(
        self,
        x_px: NDArray[np.floating],
        y_px: NDArray[np.floating],
        inverse_depth: NDArray[np.floating],
        after_s: NDArray[np.floating],
        object_id: int = 0,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Place in the frame of the thing that lies at a pixel some time later, and its depth by then.

        - `x_px`, `y_px`: places in the image at that time [px].
        - `inverse_depth`: one over its depth in the frame [1/m].
        - `after_s`: how much later, below 0 before; all four broadcast [s].
        - `object_id`: what it belongs to.

        Returns:

        - `x_px`, `y_px`: places in the frame's image [px].
        - `inverse_depth`: one over its depth at that time [1/m].
        """
        moments_s: NDArray[np.float64] = np.asarray(after_s, np.float64).reshape(-1)
        frame_from_then = (
            invert_pose(self._pose(np.zeros(1)))
            @ self._then_to_now(object_id, moments_s)
            @ self._pose(moments_s)
        ).reshape(*np.shape(after_s), 4, 4)
        # How much farther it is now than then is known but for the square of the step over the depth.
        scale = reprojected(x_px, y_px, inverse_depth, self.geometry, frame_from_then)[2]
        then = inverse_depth * scale
        x, y, _ = reprojected(x_px, y_px, then, self.geometry, frame_from_then)
        return x, y, then

    def _pose(self, after_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 4, 4) the camera in the world [m]."""
        return world_from_camera(self.agent.at(self.time_s + after_s), self.agent_from_camera)

    def _then_to_now(self, object_id: int, after_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 4, 4) from where an object's points are then to where they are in the frame [m]."""
        if (way := self.movers.get(object_id)) is None:
            return np.eye(4)[None]
        now = way.at(np.array([self.time_s]))
        return np.asarray(now @ invert_pose(way.at(self.time_s + after_s)))


def image_velocity(view: View, episode: Episode) -> NDArray[np.float32]:
    """Velocity over the image of the thing at each pixel, from the agent's motion and the depth.

    Only the camera moves: worlds stand still.

    Returns: (N, H, W, 2) float32, x to the right, y downwards [px/s].
    """
    geometry = ImageGeometry.of_camera(view.camera)
    before, after = (
        world_from_camera(episode.trajectory.at(episode.time_s + step), view.camera.agent_from_camera)
        for step in (-HALF_STEP_S, HALF_STEP_S)
    )
    x = np.arange(geometry.width_px, dtype=np.float64)
    y = np.arange(geometry.height_px, dtype=np.float64)[:, None]
    velocity = np.empty((*view.depth_m.shape, 2), np.float32)
    for out, far, first, last in zip(velocity, view.depth_m, before, after, strict=True):
        there_x, there_y, _ = reprojected(x, y, inverse_depth(far), geometry, invert_pose(last) @ first)
        out[..., 0] = (there_x - x) / (2 * HALF_STEP_S)
        out[..., 1] = (there_y - y) / (2 * HALF_STEP_S)
    return velocity
