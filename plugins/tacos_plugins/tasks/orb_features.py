"""How well features can be followed from frame to frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera.colour import LUMINANCE_WEIGHTS
from tacos_framework.contracts import Scores, State
from tacos_framework.errors import Fault, UserError, did_you_mean
from tacos_framework.settings import Settings, setting
from tacos_framework.values import FrameBatch

MATCHES_NEEDED = 8
"""Fewer matches fix no fundamental matrix with one to spare: seven define it, the eighth tests it."""


class OrbFeatures:
    """ORB features matched over consecutive frames, checked against one rigid motion of the camera.

    Keypoints of each frame are matched to those of the next one of the same walk by brute force (Hamming
    distance, mutual nearest neighbours). RANSAC with a fundamental matrix splits the matches into inliers
    and outliers.

    ``inliers``
        Mean number of inliers of a pair of frames; higher is better.
    ``inlier_ratio``
        Mean over the pairs of inliers / (inliers + outliers), in 0..1; higher is better.

    A pair with too few matches counts as zero in both; an episode without any pair has neither.

    The thresholds are in pixels of the simulated image, as in the paper: a camera with more pixels finds
    more features and is held to a finer tolerance. The detection threshold is in 1/255 of full scale.

    References
    ----------
    The paper, Sec. 4.3; Rublee et al. 2011, "ORB: an efficient alternative to SIFT or SURF"; Fischler and
    Bolles 1981, "Random sample consensus".
    """

    class Config(Settings):
        """Settings of the task."""

        camera: str | None = setting(None, help="Name of the camera that is scored; by default the first.")
        features: int = setting(2000, help="Features kept per frame, the strongest.", ge=1)
        fast_threshold: int = setting(
            20, help="Contrast a corner needs, in 1/255 of full scale.", unit="1/255", ge=1, le=254
        )
        scale_factor: float = setting(1.2, help="Ratio of neighbouring pyramid levels.", gt=1, le=2)
        levels: int = setting(8, help="Pyramid levels.", ge=1, le=32)
        patch_px: int = setting(
            31, help="Size of the patch described; as wide a border is left out.", unit="px", ge=5
        )
        ransac_threshold_px: float = setting(
            3.0, help="Distance from its epipolar line at which a match is still an inlier.", unit="px", gt=0
        )
        ransac_confidence: float = setting(
            0.99, help="Probability that RANSAC meets a sample free of outliers.", gt=0, lt=1
        )
        ransac_seed: int = setting(0, help="Seed of RANSAC, set anew for each pair.", ge=0, le=2**31 - 1)

    scores: ClassVar[tuple[str, ...]] = ("inliers", "inlier_ratio")
    score_meanings: ClassVar[Mapping[str, str]] = {
        "inliers": "features matched between frames that agree with one motion",
    }

    def __init__(self, config: Config) -> None:
        self.config = config

    def begin(self, *, state: State | None = None) -> OrbScorer:
        """A scorer for one episode."""
        return OrbScorer(self.config)


@dataclass(frozen=True)
class Features:
    """Keypoints (K, 2) float32 [px] and descriptors (K, 32) uint8 of one frame."""

    points_px: NDArray[np.float32]
    descriptors: NDArray[np.uint8]


class OrbScorer:
    """Scores one episode; keeps the last frame's features, so batches may cut anywhere."""

    def __init__(self, config: OrbFeatures.Config) -> None:
        self._config = config
        self._orb = cv2.ORB.create(
            nfeatures=config.features,
            scaleFactor=config.scale_factor,
            nlevels=config.levels,
            edgeThreshold=config.patch_px,
            patchSize=config.patch_px,
            fastThreshold=config.fast_threshold,
        )
        self._matcher = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True)
        self._last: tuple[int, Features] | None = None  # walk, features
        self._inliers: list[int] = []
        self._ratios: list[float] = []

    def update(self, frames: FrameBatch) -> None:
        """Take in the next frames."""
        images = frames.images[_camera_index(frames, self._config.camera)]
        for walk, image in zip(frames.episode.walk.tolist(), images, strict=True):
            grey = grey_image(image, frames.black_level_dn, frames.white_level_dn)
            features = self._extract(grey)
            if self._last is not None and self._last[0] == walk:
                self._score_pair(self._last[1], features)
            self._last = (walk, features)

    def scores(self) -> Scores:
        """Means over all pairs of consecutive frames so far."""
        if not self._inliers:
            return {}
        return {
            "inliers": float(np.mean(self._inliers)),
            "inlier_ratio": float(np.mean(self._ratios)),
        }

    def _extract(self, grey: NDArray[np.uint8]) -> Features:
        keypoints, descriptors = self._orb.detectAndCompute(grey, None)
        if descriptors is None:
            return Features(np.empty((0, 2), np.float32), np.empty((0, 32), np.uint8))
        points = np.asarray(cv2.KeyPoint.convert(keypoints), np.float32)
        return Features(points, np.asarray(descriptors, np.uint8))

    def _score_pair(self, first: Features, second: Features) -> None:
        matches = self._match(first, second)
        inliers = self._count_inliers(first, second, matches) if len(matches) >= MATCHES_NEEDED else 0
        self._inliers.append(inliers)
        self._ratios.append(inliers / len(matches) if len(matches) else 0.0)

    def _match(self, first: Features, second: Features) -> Sequence[Any]:
        if not (len(first.descriptors) and len(second.descriptors)):
            return ()
        matches: Sequence[Any] = self._matcher.match(first.descriptors, second.descriptors)
        return matches

    def _count_inliers(self, first: Features, second: Features, matches: Sequence[Any]) -> int:
        cv2.setRNGSeed(self._config.ransac_seed)
        fundamental, mask = cv2.findFundamentalMat(
            first.points_px[[match.queryIdx for match in matches]],
            second.points_px[[match.trainIdx for match in matches]],
            cv2.FM_RANSAC,
            self._config.ransac_threshold_px,
            self._config.ransac_confidence,
        )
        return 0 if fundamental is None else int(np.count_nonzero(mask))


def grey_image(
    image_dn: NDArray[np.uint8] | NDArray[np.uint16], black_level_dn: float, white_level_dn: float
) -> NDArray[np.uint8]:
    """Luminance of a linear frame, stretched so that black is 0 and the white level 255.

    Parameters
    ----------
    image_dn
        (H, W, C) uint8 or uint16; one channel, or linear RGB [DN].
    black_level_dn, white_level_dn
        The file's pedestal and full scale [DN].

    Returns
    -------
    NDArray
        (H, W) uint8, rounded; what lies below black is 0 [1/255 of full scale].

    Examples
    --------
    >>> frame = np.array([[[64, 64, 64], [2080, 2080, 2080], [4095, 4095, 4095]]], np.uint16)
    >>> grey_image(frame, black_level_dn=64, white_level_dn=4095).tolist()
    [[0, 128, 255]]
    """
    weights = np.array(LUMINANCE_WEIGHTS if image_dn.shape[2] == 3 else (1.0,))
    stretch = 255 / (white_level_dn - black_level_dn)
    affine = np.append(weights * stretch, -black_level_dn * stretch)
    grey = cv2.transform(image_dn, affine[None])  # rounds and saturates to the file's own type
    return np.minimum(grey, 255).astype(np.uint8).reshape(image_dn.shape[:2])


def _camera_index(frames: FrameBatch, name: str | None) -> int:
    names = [view.camera.name for view in frames.capture.views]
    if name is None:
        return 0
    if name not in names:
        expected = f"one of {', '.join(names)}"
        fault = Fault("task.orb-features", f"camera is {name!r}", expected, did_you_mean(name, names))
        raise UserError(fault)
    return names.index(name)
