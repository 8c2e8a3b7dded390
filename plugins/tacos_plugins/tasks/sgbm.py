"""Depth from stereo by OpenCV's semi-global matcher."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import CandidateFailed, FrameBatch, Rig, Scores, ScoreScale, Settings, State, setting
from tacos_plugins.tasks.stereo.depth_scores import ERRORS, MARGINS, MEANINGS, SCALES, SCORES, DepthScores
from tacos_plugins.tasks.stereo.pair import StereoPair, stereo_pair

STEP = 16
"""The matcher searches multiples of so many disparities, in sixteenths of a pixel."""

MODES = {
    "sgbm": cv2.STEREO_SGBM_MODE_SGBM,
    "3way": cv2.STEREO_SGBM_MODE_SGBM_3WAY,
    "hh": cv2.STEREO_SGBM_MODE_HH,
}


class Sgbm:
    """Semi-global block matching, untrained: quick, and the same for every candidate.

    Grey frames, coded for a display, are matched; the disparities searched follow from the
    candidate's focal length and baseline. Estimates that fail the matcher's checks are filled as KITTI does
    it: with the smaller, farther, of the nearest valid disparities to either side in the row; a row without
    any is filled likewise from the rows above and below; a frame without any is infinitely far.

    The scores are those of `DepthScores`.

    Sources: Hirschmueller 2008, "Stereo processing by semiglobal matching and mutual information"; Menze and
    Geiger 2015, "Object scene flow for autonomous vehicles" (filling of the development kit).
    """

    class Config(Settings):
        left: str | None = setting(None, help="Name of the left camera; by default the first.")
        right: str | None = setting(None, help="Name of the right camera; by default the second.")
        max_disparity: int = setting(
            192, help="Largest disparity ever searched, rounded up to a multiple of 16.", unit="px", ge=16
        )
        nearest_m: float = setting(
            2.0,
            help="Depth of the nearest points searched for; bounds the disparities of short baselines.",
            unit="m",
            gt=0,
        )
        max_depth_m: float = setting(
            1000.0, help="Depths are capped here; what lies beyond is sky.", unit="m", gt=0
        )
        block_px: int = setting(5, help="Size of the blocks compared, odd.", unit="px", ge=1, le=21)
        uniqueness_percent: int = setting(
            5, help="Margin by which the best match must win.", unit="%", ge=0, le=100
        )
        speckle_px: int = setting(
            100, help="Regions of up to so many pixels do not count; 0 keeps all.", unit="px", ge=0
        )
        mode: Literal["sgbm", "3way", "hh"] = setting(
            "sgbm", help="Paths summed over: five (sgbm), three (3way, fastest) or eight (hh)."
        )

    wants: ClassVar[Literal["grey"]] = "grey"
    needs: ClassVar[tuple[str, ...]] = ("depth",)
    scores: ClassVar[tuple[str, ...]] = SCORES
    margins: ClassVar[Mapping[str, float]] = MARGINS
    score_meanings: ClassVar[Mapping[str, str]] = MEANINGS
    lower_is_better: ClassVar[frozenset[str]] = ERRORS
    score_scales: ClassVar[Mapping[str, ScoreScale]] = SCALES

    def __init__(self, config: Config) -> None:
        self.config = config

    def lacks(self, rig: Rig) -> str | None:
        """Why the cameras of a rig cannot be matched, in a sentence; None when they can."""
        try:
            _pair_of(self.config, rig.cameras)
        except CandidateFailed as error:
            return str(error)
        return None

    def begin(self, *, state: State | None = None) -> SgbmScorer:
        return SgbmScorer(self.config)


class SgbmScorer:
    """Scores one episode."""

    def __init__(self, config: Sgbm.Config) -> None:
        self._config = config
        self._scores = DepthScores(config.max_depth_m)

    def update(self, frames: FrameBatch) -> None:
        views = frames.capture.views
        pair = _pair_of(self._config, [view.camera for view in views])
        matcher = _matcher(self._config, pair)
        both = zip(frames.images[pair.left], frames.images[pair.right], views[pair.left].depth_m, strict=True)
        for left, right, depth_m in both:
            self._scores.add(filled(_matched(matcher, left, right)), depth_m, pair)

    def scores(self) -> Scores:
        return self._scores.scores()


def searched_disparities(pair: StereoPair, *, nearest_m: float, max_disparity: int) -> int:
    """Number of disparities to search, a multiple of 16 [px].

    >>> pair = StereoPair(0, 1, width_px=640, height_px=480, focal_length_px=500, baseline_m=0.12)
    >>> searched_disparities(pair, nearest_m=2, max_disparity=192)
    32
    """
    nearest_px = min(pair.disparity_metre / nearest_m + 1, max_disparity, pair.width_px)
    return max(1, math.ceil(nearest_px / STEP)) * STEP


def filled(disparity_px: NDArray[np.float32]) -> NDArray[np.float32]:
    """A disparity map without gaps, which are below 0; see `Sgbm`.

    >>> filled(np.float32([[5, -1, 3], [-1, -1, -1]])).tolist()
    [[5.0, 3.0, 3.0], [5.0, 3.0, 3.0]]
    """
    if not (disparity_px >= 0).any():
        return np.zeros_like(disparity_px)
    return _filled_along_rows(_filled_along_rows(disparity_px).T).T


def _filled_along_rows(disparity_px: NDArray[np.float32]) -> NDArray[np.float32]:
    """Gaps take the smaller of the nearest values to either side; a row without any stays below 0."""
    before = _nearest_before(disparity_px)
    after = _nearest_before(disparity_px[:, ::-1])[:, ::-1]
    smaller = np.where((before < 0) | ((after >= 0) & (after < before)), after, before)
    return np.where(disparity_px >= 0, disparity_px, smaller)


def _nearest_before(disparity_px: NDArray[np.float32]) -> NDArray[np.float32]:
    """For each pixel the last value in its row up to it; below 0 where there is none."""
    columns = np.arange(disparity_px.shape[1])
    last = np.maximum.accumulate(np.where(disparity_px >= 0, columns, 0), axis=1)
    return np.take_along_axis(disparity_px, last, axis=1)


def _pair_of(config: Sgbm.Config, cameras: Any) -> StereoPair:
    return stereo_pair(
        cameras,
        left=config.left,
        right=config.right,
        smallest_px=2 * STEP,
        largest_px=config.max_disparity,
        max_depth_m=config.max_depth_m,
    )


def _matcher(config: Sgbm.Config, pair: StereoPair) -> Any:
    area_px = config.block_px**2
    return cv2.StereoSGBM.create(
        minDisparity=0,
        numDisparities=searched_disparities(
            pair, nearest_m=config.nearest_m, max_disparity=config.max_disparity
        ),
        blockSize=config.block_px,
        P1=8 * area_px,  # penalties of steps by one disparity and by more, as OpenCV advises
        P2=32 * area_px,
        disp12MaxDiff=1,
        preFilterCap=63,
        uniquenessRatio=config.uniqueness_percent,
        speckleWindowSize=config.speckle_px,
        speckleRange=2,
        mode=MODES[config.mode],
    )


def _matched(matcher: Any, left: NDArray[np.uint8], right: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Disparities of the left of two (H, W, 1) images, below 0 where there is none [px].

    The matcher leaves out as many columns on the left as it searches disparities; images widened by as many
    have none to leave out, and far points at the left edge are found.
    """
    margin_px = matcher.getNumDisparities()
    wide = [cv2.copyMakeBorder(grey, 0, 0, margin_px, 0, cv2.BORDER_REPLICATE) for grey in (left, right)]
    found = np.asarray(matcher.compute(*wide))[:, margin_px:]
    return np.where(found < 0, np.float32(-1), found.astype(np.float32) / STEP)
