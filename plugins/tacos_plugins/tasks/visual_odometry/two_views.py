"""The motion between two images of one camera: a rotation, and a direction without a length."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_plugins.tasks.visual_odometry.rays import on_plane, reach_plane

Floats = NDArray[np.float64]

LEAST_MATCHES = 8
"""Five matches define an essential matrix; the others test it."""

REFINEMENTS = 6
"""Steps of Gauss and Newton; the last ones change the rotation by less than 1e-6 rad."""


def motion_between(
    first: Floats, second: Floats, focal_length_px: float, consensus: cv2.UsacParams
) -> tuple[Floats, NDArray[np.bool_]] | None:
    """The motion that most matches agree with.

    Of the two rotations that an essential matrix allows, which differ by half a turn, the smaller one is
    taken: frames follow one another within a fraction of a turn. The direction is that in which more of the
    scene lies ahead. All inliers then refine the motion by their angles to the epipolar planes.

    `first`, `second`: (N, 3) unit rays of the matches in the two camera frames. `focal_length_px`: turns the
    threshold of `consensus` into an angle [px].

    Returns: (4, 4) second_from_first, with a translation of length 1, and (N,) which matches agree; None
    where no motion is found.

    Sources: Nister 2004, "An efficient solution to the five-point relative pose problem"; Hartley and
    Zisserman 2004, "Multiple view geometry", Sec. 9.6.
    """
    usable = reach_plane(first) & reach_plane(second)
    if np.count_nonzero(usable) < LEAST_MATCHES:
        return None
    pinhole = np.diag([focal_length_px, focal_length_px, 1.0])
    essential, mask = cv2.findEssentialMat(
        on_plane(first[usable], focal_length_px),
        on_plane(second[usable], focal_length_px),
        pinhole,
        pinhole,
        None,
        None,
        consensus,
    )
    if essential is None or essential.shape != (3, 3):
        return None
    inliers = usable.copy()
    inliers[usable] = mask.ravel() > 0
    if np.count_nonzero(inliers) < LEAST_MATCHES:
        return None
    one, other, translation = (np.asarray(each, np.float64) for each in cv2.decomposeEssentialMat(essential))
    smaller = max(one, other, key=np.trace)
    rotation, direction = refined(smaller, translation.ravel(), first[inliers], second[inliers])
    motion = np.eye(4)
    motion[:3, :3] = rotation
    motion[:3, 3] = direction * _side(rotation @ first[inliers].T, direction, second[inliers].T)
    return motion, inliers


def refined(rotation: Floats, direction: Floats, first: Floats, second: Floats) -> tuple[Floats, Floats]:
    """The motion nearest to the given one at which the rays lie closest to their epipolar planes.

    Residuals are Sampson's on the sphere, weighted as by Cauchy's distribution of their median size.
    """
    for _ in range(REFINEMENTS):
        turned = first @ rotation.T
        normal, back = np.cross(direction, turned), np.cross(second, direction)
        off_plane = np.sum(second * normal, axis=1)
        sampson = np.sqrt(np.sum(normal**2, axis=1) + np.sum(back**2, axis=1)) + 1e-12
        residual = off_plane / sampson
        scale = max(float(np.median(np.abs(residual))) * 1.4826, 1e-9)
        weight = 1 / (sampson * np.sqrt(1 + (residual / scale) ** 2))
        tangents = np.linalg.svd(direction[None])[2][1:]  # (2, 3)
        slopes = np.hstack([np.cross(turned, back), np.cross(turned, second) @ tangents.T])
        step, *_ = np.linalg.lstsq(slopes * weight[:, None], -off_plane * weight, rcond=None)
        rotation = cv2.Rodrigues(step[:3])[0] @ rotation
        direction = direction + tangents.T @ step[3:]
        direction /= np.linalg.norm(direction)
    return rotation, direction


def _side(turned: Floats, direction: Floats, second: Floats) -> float:
    """1 where more points lie ahead of both cameras for this direction, -1 where for its opposite.

    A point at the distances a and b has ``b second = a turned + direction``; crossed with either ray this
    gives the signs of both.
    """
    plane = np.cross(turned, second, axis=0)
    a = np.sum(plane * np.cross(second, direction[:, None], axis=0), axis=0)
    b = np.sum(plane * np.cross(turned, direction[:, None], axis=0), axis=0)
    return 1.0 if np.count_nonzero((a > 0) & (b > 0)) >= np.count_nonzero((a < 0) & (b < 0)) else -1.0
