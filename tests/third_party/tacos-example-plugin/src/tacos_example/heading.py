"""How well the direction of motion can be told from corners that move."""

from __future__ import annotations

from typing import ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray
from tacos_framework import Camera, Scores, Settings, State, setting

from tacos_example.point_tracks import Motion, Tracks

FEWEST = 8
"""Corners that an estimate needs (Longuet-Higgins 1981)."""
LOST_DEG = 90.0
"""Error where there is no estimate: that of a guess, on average."""


class Heading:
    """Estimates the direction of motion from the essential matrix of each pair of frames.

    ``error_deg``
        Mean angle between estimated and true direction; lower is better, so its weight is negative.
    ``tracks``
        Mean number of corners that were followed; higher is better.
    """

    class Config(Settings):
        tolerance_px: float = setting(
            1.0, help="Farthest that a corner of the estimate may lie off.", unit="px", gt=0
        )

    scores: ClassVar[tuple[str, ...]] = ("error_deg", "tracks")
    lower_is_better: ClassVar[frozenset[str]] = frozenset({"error_deg"})

    def __init__(self, config: Config) -> None:
        self.config = config

    def begin(self, *, state: State | None) -> HeadingScorer:
        """A scorer for one episode."""
        return HeadingScorer(self.config.tolerance_px)


class HeadingScorer:
    """Keeps an angle and a count for each pair of frames."""

    def __init__(self, tolerance_px: float) -> None:
        self._tolerance_px = tolerance_px
        self._errors_deg: list[float] = []
        self._counts: list[int] = []

    def update(self, tracks: Tracks) -> None:
        """Take in the next motions: the type of this parameter is the port."""
        for motion in tracks.motions:
            self._counts.append(len(motion.before_px))
            self._errors_deg.append(self._error_deg(motion, tracks.camera))

    def scores(self) -> Scores:
        """The means; no scores where nothing moved."""
        if not self._counts:
            return {}
        return {"error_deg": float(np.mean(self._errors_deg)), "tracks": float(np.mean(self._counts))}

    def _error_deg(self, motion: Motion, camera: Camera) -> float:
        truth = motion.before_from_after[:3, 3]
        if len(motion.before_px) < FEWEST or not truth.any():
            return LOST_DEG
        matrix = intrinsic_matrix(camera)
        essential, inliers = cv2.findEssentialMat(
            motion.before_px, motion.after_px, matrix, cv2.RANSAC, 0.999, self._tolerance_px
        )
        if essential is None or essential.shape != (3, 3):
            return LOST_DEG
        _, _, after_from_before, _ = cv2.recoverPose(
            essential, motion.before_px, motion.after_px, matrix, mask=inliers
        )
        estimate = -after_from_before[:, 0]  # of hardly any rotation; towards where the camera moves
        cosine = float(estimate @ truth / np.linalg.norm(truth))
        return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def intrinsic_matrix(camera: Camera) -> NDArray[np.float64]:
    """(3, 3) matrix of a pinhole camera, with pixel centres at whole numbers [px]."""
    focal_px = camera.focal_length_mm / (camera.pixel_um * 1e-3)
    column, row = (camera.width_px - 1) / 2, (camera.height_px - 1) / 2
    return np.array([[focal_px, 0, column], [0, focal_px, row], [0, 0, 1]])
