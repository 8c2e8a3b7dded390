"""Pose of a board before a camera."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import ImageGeometry
from tacos_framework.camera import rays_of_pixels

Array = NDArray[np.float64]

LEAST_AHEAD = 0.1
"""Corners further off the middle of a board than 84 degrees are taken to lie there."""


@dataclass(frozen=True, eq=False)
class Pose:
    """From the board's frame to the camera's. `shift_mm`: (3,) the board's origin before the camera [mm]."""

    rotation: Array
    shift_mm: Array


def first_pose(points_mm: Array, places_px: Array, geometry: ImageGeometry) -> Pose:
    """The pose of a flat board that is seen at places, by its homography and then least squares.

    Where there is none, as for places on a line, the board faces the camera, at the distance of its size. A
    lens may image the board beside the camera, so it is sought by a camera turned towards it.
    """
    if geometry.lens.is_pinhole:
        tangents = np.ascontiguousarray((places_px - np.array(geometry.centre_px)) / geometry.focal_length_px)
        return _ahead(points_mm, tangents)
    rays = rays_of_pixels(places_px, geometry)
    turned = _turned_to(np.nanmean(rays, axis=0))
    seen = np.nan_to_num(rays) @ turned.T
    found = _ahead(points_mm, np.ascontiguousarray(seen[:, :2] / np.maximum(seen[:, 2:], LEAST_AHEAD)))
    return Pose(turned.T @ found.rotation, turned.T @ found.shift_mm)


def _turned_to(ray: Array) -> Array:
    """(3, 3) rotation to the frame of a camera that looks along a ray."""
    ray = ray / np.linalg.norm(ray)
    axis = np.cross(ray, [0.0, 0.0, 1.0])
    sine = float(np.linalg.norm(axis))
    angle = np.arctan2(sine, ray[2])
    return np.asarray(cv2.Rodrigues(axis / max(sine, 1e-12) * angle)[0], np.float64)


def _ahead(points_mm: Array, tangents: Array) -> Pose:
    """The pose of a board that a pinhole sees at tangents."""
    try:
        found, turn, shift = cv2.solvePnP(points_mm, tangents, np.eye(3), None, flags=cv2.SOLVEPNP_ITERATIVE)
    except cv2.error:  # a hypothesis may put all places on a line or a point
        found = False
    if found and np.isfinite(turn).all() and np.isfinite(shift).all() and shift[2, 0] > 0:
        rotation = cv2.Rodrigues(turn)[0]
        return Pose(np.asarray(rotation, np.float64), np.asarray(shift, np.float64).ravel())
    size = float(np.linalg.norm(points_mm.std(axis=0)))
    distance = size / max(float(np.linalg.norm(tangents.std(axis=0))), 1e-6)
    aim = np.append(tangents.mean(axis=0), 1.0) * distance
    return Pose(np.eye(3), aim - points_mm.mean(axis=0))


def moved_pose(pose: Pose, move: Array) -> Pose:
    """A pose turned by (3,) radians about the board's origin and shifted by (3,) mm, in the camera's axes."""
    return Pose(cv2.Rodrigues(move[:3])[0] @ pose.rotation, pose.shift_mm + move[3:])
