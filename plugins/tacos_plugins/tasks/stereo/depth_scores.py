"""Scores of estimated depth, added up frame by frame."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Scores, ScoreScale
from tacos_plugins.tasks.stereo.pair import StereoPair

SCORES = ("log_error", "inverse_log_error", "rmse_m", "d1", "log_error_all", "rmse_all_m")
"""Scores of stereo tasks; see `DepthScores`."""

ERRORS = frozenset(SCORES) - {"inverse_log_error"}
"""Those of them of which less is better."""

SCALES: dict[str, ScoreScale] = {"d1": "share"}
"""Those of them that are no plain numbers."""

MARGINS = {
    "log_error": 0.002,
    "inverse_log_error": 0.2,
    "rmse_m": 1.0,
    "d1": 0.01,
    "log_error_all": 0.002,
    "rmse_all_m": 1.0,
}
"""Differences that do not matter: a fifth of a percent of a distance, a metre over a whole street."""

MEANINGS = {
    "log_error": "mean error of the logarithm of depth",
    "inverse_log_error": "one over the mean error of the logarithm of depth",
    "rmse_m": "root of the mean squared error of depth",
    "d1": "share of pixels whose disparity is off by more than 3 px and 5 %",
    "log_error_all": "the same, the sky included",
    "rmse_all_m": "the same, the sky included",
}
"""Their meanings, for reports."""

LEAST_LOG_ERROR = 1e-3
"""Log errors below count as this much in their inverse, which would have no bound otherwise [1]."""

OUTLIER_PX, OUTLIER_SHARE = 3.0, 0.05
"""An estimate is an outlier beyond both: so far off, and by such a share of the truth (KITTI 2015)."""


class DepthScores:
    """Scores of estimated disparities against the depth that was rendered.

    With Z the true depth and Z' the estimated one, both capped at a largest depth:

    ``log_error``
        Mean of ``|ln Z - ln Z'|``; *lower* is better. Equal to that of disparities over baselines.
    ``inverse_log_error``
        ``1 / log_error``, the paper's fitness; higher is better. A log error below 0.001 counts as 0.001.
    ``rmse_m``
        Root of the mean of ``(Z - Z')^2``; *lower* is better [m].
    ``d1``
        Share of outliers, whose disparity is off by more than 3 px and by more than 5 %, in 0..1; *lower* is
        better.
    ``log_error_all``, ``rmse_all_m``
        The same over all pixels, what lies beyond the largest depth (the sky) included as if it stood there.

    The others are over the pixels nearer than the largest depth; an episode without any has none of them.
    Sums run over pixels of all frames alike, and memory does not grow with their number.

    Source: the paper, Sec. 4.2 and supplement (depth capped at 1000 m); Menze and Geiger 2015 (d1).
    """

    def __init__(self, max_depth_m: float) -> None:
        self._max_depth_m = max_depth_m
        self._near = _Sums()
        self._all = _Sums()
        self._outliers = 0

    def add(
        self, disparity_px: NDArray[np.floating[Any]], depth_m: NDArray[np.floating[Any]], pair: StereoPair
    ) -> None:
        """Take in a frame.

        `disparity_px`: (H, W) estimates in the left image; 0 or below stands for infinitely far [px].
        `depth_m`: (H, W) truth of the left camera; infinite where nothing is [m].
        """
        near = depth_m < self._max_depth_m
        truth_m = np.minimum(depth_m, self._max_depth_m).astype(np.float64)
        found_m = pair.depth_m(disparity_px, max_depth_m=self._max_depth_m)
        log_error = np.abs(np.log(truth_m) - np.log(found_m))
        square_m2 = np.square(truth_m - found_m)
        self._near.add(log_error[near], square_m2[near])
        self._all.add(log_error, square_m2)
        truth_px = pair.disparity_px(truth_m[near])
        off_px = np.abs(disparity_px[near] - truth_px)
        self._outliers += int(np.count_nonzero((off_px > OUTLIER_PX) & (off_px > OUTLIER_SHARE * truth_px)))

    def scores(self) -> Scores:
        found: dict[str, float] = {}
        if self._near.count:
            log_error = self._near.log_error
            found["log_error"] = log_error
            found["inverse_log_error"] = 1 / max(log_error, LEAST_LOG_ERROR)
            found["rmse_m"] = self._near.rmse_m
            found["d1"] = self._outliers / self._near.count
        if self._all.count:
            found["log_error_all"] = self._all.log_error
            found["rmse_all_m"] = self._all.rmse_m
        return found


class _Sums:
    """Sums over pixels."""

    def __init__(self) -> None:
        self.count = 0
        self._log_error = 0.0
        self._square_m2 = 0.0

    def add(self, log_error: NDArray[np.float64], square_m2: NDArray[np.float64]) -> None:
        self.count += log_error.size
        self._log_error += float(log_error.sum())
        self._square_m2 += float(square_m2.sum())

    @property
    def log_error(self) -> float:
        return self._log_error / self.count

    @property
    def rmse_m(self) -> float:
        return float(np.sqrt(self._square_m2 / self.count))
