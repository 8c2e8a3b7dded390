"""Markers in sight, what was read of them, and the scores made of that."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, Scores
from tacos_framework.camera import invert_pose, pixels_of_rays, rays_of_pixels
from tacos_plugins.tasks.fiducials.families import Tag
from tacos_plugins.tasks.visual_odometry.errors import grade
from tacos_plugins.tasks.visual_odometry.rays import on_plane, reach_plane

Floats = NDArray[np.float64]

STEEPNESS = 6
"""Exponent of the share detected over distance, 1 / (1 + (d / range)^6): from .9 to .1 over a factor of 2."""
POSITION_SHARE = (0.001, 1.0)
"""Errors of position over distance that are graded 1 and 0."""
BEHIND = 1.05
"""Factor of the depth below which something hides a marker."""


@dataclass(frozen=True)
class Sighting:
    """A marker in sight of a frame: how far it is [m], whether it was read, its error of position [m], and
    whether it is in the field of work."""

    distance_m: float
    read: bool
    off_m: float | None = None
    in_field: bool = True


def in_sight(
    tag: Tag, camera: Camera, world_from_camera: Floats, depth_m: NDArray[np.float32]
) -> float | None:
    """Distance to a marker that is whole in the image, faces the camera and is not hidden; else None [m]."""
    camera_from_world = invert_pose(world_from_camera)
    corners = tag.corners_m @ camera_from_world[:3, :3].T + camera_from_world[:3, 3]
    middle = corners.mean(axis=0)
    normal = np.cross(corners[3] - corners[0], corners[1] - corners[0])  # towards its reader
    if normal @ middle >= 0:
        return None
    pixels = pixels_of_rays(np.vstack([corners, middle]), camera)
    size = np.array([camera.width_px, camera.height_px])
    if not np.all((pixels >= -0.5) & (pixels < size - 0.5)):
        return None
    along = middle[2] if camera.lens.is_rectilinear else np.linalg.norm(middle)  # as `View.depth_m` is
    column, row = np.rint(pixels[4]).astype(int)
    hidden = depth_m[min(row, size[1] - 1), min(column, size[0] - 1)] * BEHIND < along
    return None if hidden else float(np.linalg.norm(middle))


def in_field_of_work(
    tag: Tag, eye_m: Floats, world_from_agent: Floats, within_m: float, within_deg: float
) -> bool:
    """Whether a marker faces the camera at `eye_m`, is near enough and close enough to straight ahead.

    Geometry alone, the same for every camera: what hangs behind a wall is in it, too.
    """
    away = tag.corners_m.mean(axis=0) - eye_m
    distance_m = np.linalg.norm(away)
    normal = np.cross(tag.corners_m[3] - tag.corners_m[0], tag.corners_m[1] - tag.corners_m[0])
    ahead = away @ world_from_agent[:3, 0] >= math.cos(math.radians(within_deg)) * distance_m
    return bool(normal @ away < 0 and ahead and distance_m <= within_m)


def is_there(tag: Tag, corners_px: Floats, camera: Camera, world_from_camera: Floats) -> bool:
    """Whether corners found lie about the marker's middle: noise reads as markers elsewhere now and then."""
    camera_from_world = invert_pose(world_from_camera)
    middle = camera_from_world[:3, :3] @ tag.corners_m.mean(axis=0) + camera_from_world[:3, 3]
    place = pixels_of_rays(middle, camera).astype(np.float32)
    return cv2.pointPolygonTest(corners_px.astype(np.float32), (float(place[0]), float(place[1])), False) >= 0


def off_m(tag: Tag, corners_px: Floats, camera: Camera, world_from_camera: Floats) -> float | None:
    """Distance of the middle of a marker from its place by (4, 2) corners in the image; None without one.

    Of the two poses that a square has in perspective, that of the smaller error in the image is taken.

    Source: Collins and Bartoli 2014, "Infinitesimal plane-based pose estimation".
    """
    rays = rays_of_pixels(corners_px, camera)
    if not reach_plane(rays).all():
        return None
    half = tag.edge_m / 2
    square = np.array([[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]])
    focal_px = camera.focal_length_px
    pinhole = np.diag([focal_px, focal_px, 1.0])
    found, _, shift = cv2.solvePnP(
        square, on_plane(rays, focal_px), pinhole, None, flags=cv2.SOLVEPNP_IPPE_SQUARE
    )
    truth = invert_pose(world_from_camera) @ np.append(tag.corners_m.mean(axis=0), 1)
    return float(np.linalg.norm(shift.ravel() - truth[:3])) if found else None


def range_m(sightings: Sequence[Sighting]) -> float:
    """Distance at which half of the markers are read, most likely by how many were at each distance.

    Never beyond twice the farthest in sight, nor below half of the nearest; 0 where none is read.
    """
    if not any(each.read for each in sightings):
        return 0.0
    distances = np.array([each.distance_m for each in sightings])
    read = np.array([each.read for each in sightings])
    ranges = np.geomspace(distances.min() / 2, distances.max() * 2, 200)[:, None]
    odds = STEEPNESS * np.log(ranges / distances)
    likelihood = -np.logaddexp(0, np.where(read, -odds, odds)).sum(axis=1)
    return float(ranges[likelihood.argmax(), 0])


def scores_of(sightings: Sequence[Sighting], *, missed: int = 0) -> Scores:
    """The scores of `Fiducials`; none where no marker was to be read.

    `missed`: markers of the field of work that were not in sight.
    """
    near = [each for each in sightings if each.in_field]
    count = len(near) + missed
    if not count:
        return {}
    shares = [each.off_m / each.distance_m for each in near if each.off_m is not None]
    scores: dict[str, float] = {
        "read": sum(each.read for each in near) / count,
        "range_m": range_m(sightings),
        "position": sum(grade(share, POSITION_SHARE) for share in shares) / count,
    }
    if shares:
        scores["position_error"] = float(np.median(shares))
    return scores


def detected(detector: cv2.aruco.ArucoDetector, grey: NDArray[np.uint8]) -> Mapping[int, Floats]:
    """Corners (4, 2) of the markers found, by their numbers; the largest where a number comes twice [px]."""
    corners, numbers, _ = detector.detectMarkers(grey)
    found: dict[int, Floats] = {}
    for square, number in zip(corners, [] if numbers is None else map(int, numbers.ravel()), strict=True):
        places = np.asarray(square, np.float64).reshape(4, 2)
        if number not in found or _area(places) > _area(found[number]):
            found[number] = places
    return found


def _area(corners: Floats) -> float:
    return math.fabs(cv2.contourArea(corners.astype(np.float32)))
