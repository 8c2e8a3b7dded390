"""Features followed from frame to frame."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

import cv2
import numpy as np
from pydantic import Field

from tacos_framework import FrameBatch, Scores, ScoreScale, Settings, State, setting
from tacos_plugins.tasks.chosen_camera import camera_index
from tacos_plugins.tasks.followed_features import (
    Features,
    FollowedFeatures,
    extract,
    extract_spread,
    follow,
    grey_image,
    with_rays,
)

LEAST_PATCH_PX = 5
"""A descriptor compares points of a patch that was smoothed over 7 x 7 pixels: of less, none differ."""

TIME_TOLERANCE_S = 1e-6
"""Frames at a stated distance in time are so far apart but for rounding [s]."""


CANDIDATES = 6
"""Features looked for in the whole image per feature wanted, where they are shared out among cells."""

Cells = Annotated[int, Field(ge=1, le=64)]
Scaled = Literal["features", "levels", "patch_px", "border_px", "ransac_threshold_px"]
"""Settings that may follow the binning of the simulation."""


class OrbFeatures:
    """ORB features matched over consecutive frames, checked against one rigid motion of the camera.

    Keypoints of each frame are matched to those of the next one of the same walk by brute force (Hamming
    distance, mutual nearest neighbours). RANSAC with a fundamental matrix splits the matches into inliers
    and outliers.

    ``inliers``
        Mean number of inliers of a pair of frames; higher is better.
    ``inlier_ratio``
        Mean over the pairs of inliers / features extracted, the mean of the two frames' counts, in 0..1;
        higher is better. With ``ratio_of: matches`` it is inliers / (inliers + outliers).
    ``matches``
        Mean number of matches of a pair.
    ``extracted``
        Mean number of features extracted from a frame of a pair.

    A pair with too few matches has no inliers; an episode without any pair has no scores.

    Where the simulation averages b x b of the camera's pixels (`Camera.simulated_binning`), the settings
    named in ``scale_with_binning`` follow b. The features are divided by it, which keeps as many of them per
    length of the image, and so is the border, which leaves out the same margin of the scene. RANSAC's
    threshold, divided, is the same angle; undivided it lets cameras of few pixels follow more than they would
    at full resolution. Of the levels the finest are dropped, which the binning has averaged away: the
    coarsest stays as coarse in the scene. The patch stays: a descriptor needs pixels.

    With ``cells`` each of equal parts of the image gives its share of the features and no more: what is full
    or black there costs them, and is not made up for elsewhere.

    Images are grey and coded for a display, as programs get them; `images: linear` takes linear ones, in
    which what is dark has little contrast.

    A camera with more photosites finds more features and is held to a finer tolerance, as in the paper. The
    detection threshold is in 1/255 of full scale.

    Sources: The paper, Sec. 4.3; Rublee et al. 2011, "ORB: an efficient alternative to SIFT or SURF";
    Fischler and Bolles 1981, "Random sample consensus".
    """

    class Config(Settings):
        camera: str | None = setting(None, help="Name of the camera that is scored; by default the first.")
        features: int = setting(2000, help="Features kept per frame, the strongest.", ge=1)
        cells: tuple[Cells, Cells] = setting(
            (1, 1),
            help="Columns and rows of cells that share the features evenly, as SLAM does: no part of the "
            "image stands in for the others.",
        )
        fast_threshold: int = setting(
            20, help="Contrast a corner needs, in 1/255 of full scale.", unit="1/255", ge=1, le=254
        )
        images: Literal["coded", "linear"] = setting(
            "coded", help="Files in which features are found: coded for a display, or linear."
        )
        scale_factor: float = setting(1.2, help="Ratio of neighbouring pyramid levels.", gt=1, le=2)
        levels: int = setting(8, help="Pyramid levels.", ge=1, le=32)
        patch_px: int = setting(31, help="Size of the patch described.", unit="px", ge=5)
        border_px: int | None = setting(
            None, help="Border without keypoints; by default as wide as the patch.", unit="px", ge=1
        )
        ransac_threshold_px: float = setting(
            3.0, help="Distance from its epipolar line at which a match is still an inlier.", unit="px", gt=0
        )
        scale_with_binning: tuple[Scaled, ...] = setting(
            ("features", "border_px"),
            help="Settings that follow the simulation's binning; the others stay as they are.",
        )
        ransac_confidence: float = setting(
            0.99, help="Probability that RANSAC meets a sample free of outliers.", gt=0, lt=1
        )
        ransac_seed: int = setting(0, help="Seed of RANSAC, set anew for each pair.", ge=0, le=2**31 - 1)
        pair_within_s: float | None = setting(
            None,
            help="Match only frames at most this far apart in time; by default all that follow one another.",
            unit="s",
            gt=0,
        )
        ratio_of: Literal["features", "matches"] = setting(
            "features", help="Denominator of inlier_ratio: the features extracted, or the matches."
        )

    scores: ClassVar[tuple[str, ...]] = ("inliers", "inlier_ratio", "matches", "extracted")
    score_scales: ClassVar[Mapping[str, ScoreScale]] = {
        "inliers": "count",
        "inlier_ratio": "share",
        "matches": "count",
        "extracted": "count",
    }
    margins: ClassVar[Mapping[str, float]] = {
        "inliers": 5.0,
        "inlier_ratio": 0.01,
        "matches": 5.0,
        "extracted": 5.0,
    }
    """Five features are what RANSAC's own draws change on a pair of frames with outliers."""
    score_meanings: ClassVar[Mapping[str, str]] = {
        "inliers": "features matched between frames that agree with one motion",
        "inlier_ratio": "share of the features found that agree with one motion",
    }

    def __init__(self, config: Config) -> None:
        self.config = config

    @property
    def wants(self) -> Literal["linear", "grey"]:
        return "linear" if self.config.images == "linear" else "grey"

    def begin(self, *, state: State | None = None) -> OrbScorer:
        return OrbScorer(self.config)


@dataclass(frozen=True)
class Scale:
    """Settings counted in pixels, for the image as it is."""

    features: int
    """Features kept per frame [1]."""
    levels: int
    """Pyramid levels [1]."""
    patch_px: int
    border_px: int
    """Edge of the patch, and border without keypoints [px]."""
    ransac_threshold_px: float
    """Distance from the epipolar line of an inlier [px]."""

    @classmethod
    def of(cls, config: OrbFeatures.Config, binning: float) -> Scale:
        """That of images whose pixels average `binning` x `binning` of the camera's.

        >>> Scale.of(OrbFeatures.Config(), binning=2)
        Scale(features=1000, levels=8, patch_px=31, border_px=16, ransac_threshold_px=3.0)
        """

        def scaled(name: Scaled, value: float) -> float:
            return value / binning if name in config.scale_with_binning else value

        border = config.patch_px if config.border_px is None else config.border_px
        averaged = math.log(binning, config.scale_factor) if "levels" in config.scale_with_binning else 0
        return cls(
            features=max(1, round(scaled("features", config.features))),
            levels=max(1, config.levels - round(averaged)),
            patch_px=max(LEAST_PATCH_PX, round(scaled("patch_px", config.patch_px))),
            border_px=max(1, round(scaled("border_px", border))),
            ransac_threshold_px=scaled("ransac_threshold_px", config.ransac_threshold_px),
        )

    def detector(self, config: OrbFeatures.Config) -> Any:
        return cv2.ORB.create(
            nfeatures=self.features * (1 if config.cells == (1, 1) else CANDIDATES),
            scaleFactor=config.scale_factor,
            nlevels=self.levels,
            edgeThreshold=self.border_px,
            patchSize=self.patch_px,
            fastThreshold=config.fast_threshold,
        )


@dataclass(frozen=True)
class LastFrame:
    """The frame before: its walk, time [s] and features."""

    walk: int
    time_s: float
    features: Features


class OrbScorer:
    """Scores one episode; keeps the last frame's features, so batches may cut anywhere."""

    def __init__(self, config: OrbFeatures.Config) -> None:
        self._config = config
        self._last: LastFrame | None = None
        self._pairs: list[FollowedFeatures] = []

    def update(self, frames: FrameBatch) -> None:
        index = camera_index(frames, self._config.camera, where="task.orb-features")
        camera = frames.capture.views[index].camera
        scale = Scale.of(self._config, camera.simulated_binning)
        orb = scale.detector(self._config)
        episode = frames.episode
        for walk, time_s, image in zip(
            episode.walk.tolist(), episode.time_s.tolist(), frames.images[index], strict=True
        ):
            grey = grey_image(image, frames.black_level_dn, frames.white_level_dn)
            if self._config.cells == (1, 1):
                found = extract(orb, grey)
            else:
                found = extract_spread(orb, grey, cells=self._config.cells, most=scale.features)
            frame = LastFrame(walk, time_s, with_rays(found, camera))
            if self._last is not None and self._are_pair(self._last, frame):
                self._pairs.append(self._follow(self._last.features, frame.features, scale))
            self._last = frame

    def scores(self) -> Scores:
        """Means over all pairs of consecutive frames so far."""
        if not self._pairs:
            return {}
        return {
            "inliers": float(np.mean([pair.inliers for pair in self._pairs])),
            "inlier_ratio": float(np.mean([pair.ratio(self._config.ratio_of) for pair in self._pairs])),
            "matches": float(np.mean([pair.matches for pair in self._pairs])),
            "extracted": float(np.mean([pair.extracted for pair in self._pairs])),
        }

    def _are_pair(self, first: LastFrame, second: LastFrame) -> bool:
        limit_s = self._config.pair_within_s
        near = limit_s is None or second.time_s - first.time_s <= limit_s + TIME_TOLERANCE_S
        return first.walk == second.walk and near

    def _follow(self, first: Features, second: Features, scale: Scale) -> FollowedFeatures:
        config = self._config
        return follow(
            first,
            second,
            threshold_px=scale.ransac_threshold_px,
            confidence=config.ransac_confidence,
            seed=config.ransac_seed,
        )
