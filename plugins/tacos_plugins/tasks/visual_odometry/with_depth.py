"""The motion of a stereo pair: points triangulated once, and seen again."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_plugins.tasks.visual_odometry.rays import on_plane, reach_plane

Floats = NDArray[np.float64]

LEAST_POINTS = 6
"""Three points define a pose; the others test it."""


def triangulated(
    left: Floats, right: Floats, left_from_right: Floats, tolerance_rad: float
) -> tuple[Floats, NDArray[np.bool_]]:
    """Points nearest to both rays of a match.

    - `left`, `right`: (N, 3) unit rays in the camera frames.
    - `left_from_right`: (4, 4) pose of the right camera [m].
    - `tolerance_rad`: angle between a ray and the point from which on a match is none [rad].

    Returns: (N, 3) points in the frame of the left camera [m], and (N,) which lie ahead on both rays.
    """
    origin = left_from_right[:3, 3]
    other = right @ left_from_right[:3, :3].T
    along = np.sum(left * other, axis=1)
    spread = np.maximum(1 - along**2, 1e-12)
    a = (left @ origin - along * (other @ origin)) / spread
    b = (along * (left @ origin) - other @ origin) / spread
    one, two = a[:, None] * left, origin + b[:, None] * other
    gap_m = np.linalg.norm(one - two, axis=1)
    valid = (a > 0) & (b > 0) & (gap_m < 2 * tolerance_rad * np.maximum(a, 1e-9))
    return (one + two) / 2, valid


def motion_of_points(
    points_m: Floats, second: Floats, focal_length_px: float, consensus: cv2.UsacParams
) -> tuple[Floats, NDArray[np.bool_]] | None:
    """The motion under which most points are seen where they are.

    `points_m`: (N, 3) in the camera frame before the motion [m]. `second`: (N, 3) unit rays along which they
    are seen after it.

    Returns: (4, 4) second_from_first [m] and (N,) which points agree; None where no motion is found.
    """
    usable = reach_plane(second)
    if np.count_nonzero(usable) < LEAST_POINTS:
        return None
    pinhole = np.diag([focal_length_px, focal_length_px, 1.0])
    points, seen = points_m[usable], on_plane(second[usable], focal_length_px)
    found, _, turn, shift, agreeing = cv2.solvePnPRansac(points, seen, pinhole, None, params=consensus)
    if not found or agreeing is None or len(agreeing) < LEAST_POINTS:
        return None
    agreeing = agreeing.ravel()
    turn, shift = cv2.solvePnPRefineLM(points[agreeing], seen[agreeing], pinhole, None, turn, shift)
    motion = np.eye(4)
    motion[:3, :3], motion[:3, 3] = cv2.Rodrigues(turn)[0], shift.ravel()
    inliers = np.zeros(len(points_m), bool)
    inliers[np.flatnonzero(usable)[agreeing]] = True
    return motion, inliers
