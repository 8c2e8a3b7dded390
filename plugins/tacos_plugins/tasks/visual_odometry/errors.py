"""Errors of estimated motions, and the scores made of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Scores

ROTATION_DEG = (0.001, 10.0)
"""Errors that are graded 1 and 0: the best ends where twelve megapixels do, the worst where a map is lost."""
DIRECTION_DEG = (0.03, 30.0)
POSITION_SHARE = (0.001, 1.0)
"""Of the way; the best stereo odometry on KITTI drifts by .005 of it."""
LOST_DEG = 180.0
"""The error of a motion that was not found [deg]."""


@dataclass(frozen=True)
class MotionError:
    """Errors of one estimate; None where there is nothing to tell them by."""

    found: bool
    """True if there is an estimate at all."""
    rotation_deg: float
    """Angle between the rotations [deg]."""
    direction_deg: float | None
    """Angle between the translations; None where the camera hardly moved [deg]."""
    position_share: float | None
    """Distance between the translations over the length of the true one, where lengths are estimated [1]."""


def motion_error(
    estimate: NDArray[np.float64] | None,
    truth: NDArray[np.float64],
    *,
    least_step_m: float,
    with_length: bool,
) -> MotionError:
    """That of (4, 4) second_from_first, against the true one; None is a motion that was not found.

    >>> truth, estimate = np.eye(4), np.eye(4)
    >>> truth[:3, 3], estimate[:3, 3] = (1.0, 0.0, 0.0), (1.0, 0.1, 0.0)
    >>> error = motion_error(estimate, truth, least_step_m=0.02, with_length=True)
    >>> error.rotation_deg, round(error.direction_deg, 2), round(error.position_share, 3)
    (0.0, 5.71, 0.1)
    """
    step_m = float(np.linalg.norm(truth[:3, 3]))
    moved = step_m >= least_step_m
    if estimate is None:
        lost = 1.0 if moved and with_length else None
        return MotionError(False, LOST_DEG, LOST_DEG if moved else None, lost)
    off = estimate[:3, :3].T @ truth[:3, :3]
    axis = np.array([off[2, 1] - off[1, 2], off[0, 2] - off[2, 0], off[1, 0] - off[0, 1]])
    rotation = math.atan2(float(np.linalg.norm(axis)), float(np.trace(off)) - 1)
    direction = position = None
    if moved:
        ours, theirs = estimate[:3, 3], truth[:3, 3]
        across = float(np.linalg.norm(np.cross(ours, theirs)))
        direction = math.degrees(math.atan2(across, float(ours @ theirs)))
        position = float(np.linalg.norm(ours - theirs)) / step_m if with_length else None
    return MotionError(True, math.degrees(rotation), direction, position)


def grade(error: float, best_and_worst: tuple[float, float]) -> float:
    """1 for errors up to the best, 0 from the worst on, and even steps for equal ratios between.

    >>> [round(grade(error, (0.01, 10.0)), 2) for error in (0.001, 0.1, 1.0, 90.0)]
    [1.0, 0.67, 0.33, 0.0]
    """
    best, worst = best_and_worst
    return min(1.0, max(0.0, math.log(worst / max(error, 1e-12)) / math.log(worst / best)))


def scores_of(errors: Sequence[MotionError]) -> Scores:
    """The scores of `VisualOdometry`; those without anything to tell them by are left out."""
    if not errors:
        return {}
    rotations = [each.rotation_deg for each in errors]
    directions = [each.direction_deg for each in errors if each.direction_deg is not None]
    positions = [each.position_share for each in errors if each.position_share is not None]
    scores = {
        "tracked": _mean([float(each.found) for each in errors]),
        "rotation": _mean([grade(error, ROTATION_DEG) for error in rotations]),
        "rotation_error_deg": float(np.median(rotations)),
        "within_1_deg": _mean([float(error <= 1.0) for error in rotations]),
    }
    if directions:
        scores["direction"] = _mean([grade(error, DIRECTION_DEG) for error in directions])
        scores["direction_error_deg"] = float(np.median(directions))
    if positions:
        scores["position"] = _mean([grade(error, POSITION_SHARE) for error in positions])
        scores["drift"] = float(np.median(positions))
    return scores


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)
