"""Features of a frame, and which of them are found again in the next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera
from tacos_framework.camera import LUMINANCE_WEIGHTS, rays_of_pixels
from tacos_plugins.tasks.consensus import fundamental_matrix, seeded

MATCHES_NEEDED = 8
"""Fewer matches fix no fundamental matrix with one to spare: seven define it, the eighth tests it."""


_AHEAD = float(np.cos(np.radians(70)))


@dataclass(frozen=True, eq=False)
class Features:
    """Keypoints (K, 2) float32 [px] and descriptors (K, 32) uint8 of one frame.

    Of a fisheye also (K, 3) where they look, as vectors of the focal length's length [px].
    """

    points_px: NDArray[np.float32]
    descriptors: NDArray[np.uint8]
    rays_px: NDArray[np.float64] | None = None

    def __len__(self) -> int:
        return len(self.points_px)


@dataclass(frozen=True)
class FollowedFeatures:
    """Counts of a pair of frames."""

    extracted: float
    """Features of a frame, the mean of both [1]."""
    matches: int
    """Those of either that are matched to one of the other [1]."""
    inliers: int
    """Those of the matches that agree with one rigid motion of the camera [1]."""

    def ratio(self, of: Literal["features", "matches"]) -> float:
        """Inliers as a share of either; 0 where there is nothing to be a share of."""
        whole = self.extracted if of == "features" else self.matches
        return self.inliers / whole if whole else 0.0


def extract(detector: Any, grey: NDArray[np.uint8]) -> Features:
    """The features an OpenCV detector with binary descriptors finds in a (H, W) image."""
    return _features(*detector.detectAndCompute(grey, None))


def extract_spread(detector: Any, grey: NDArray[np.uint8], *, cells: tuple[int, int], most: int) -> Features:
    """Features spread over the image: of each cell the strongest, an even share of `most` or at least one.

    A cell in which too little is found stays short: others do not make up for it.

    - `detector`: an OpenCV detector that finds more than `most`, with the strength of each.
    - `cells`: columns and rows of equal cells [1].
    - `most`: features wanted of the whole image [1].

    Source: Mur-Artal, Montiel, Tardos 2015, "ORB-SLAM: a versatile and accurate monocular SLAM system", Sec.
    V-A.
    """
    keypoints = sorted(detector.detect(grey, None), key=lambda each: -each.response)
    columns, rows = cells
    height, width = grey.shape
    room = [max(1, most // (columns * rows))] * (columns * rows)
    kept = []
    for keypoint in keypoints:
        x_px, y_px = keypoint.pt
        cell = int(y_px * rows / height) * columns + int(x_px * columns / width)
        if room[cell]:
            room[cell] -= 1
            kept.append(keypoint)
    return _features(*detector.compute(grey, kept))


def _features(keypoints: Sequence[Any], descriptors: NDArray[np.uint8] | None) -> Features:
    if descriptors is None:
        return Features(np.empty((0, 2), np.float32), np.empty((0, 32), np.uint8))
    points = np.asarray(cv2.KeyPoint.convert(keypoints), np.float32)
    return Features(points, np.asarray(descriptors, np.uint8))


def with_rays(features: Features, camera: Camera) -> Features:
    """Features that know where they look, if the camera is no pinhole."""
    if camera.lens.is_pinhole:
        return features
    rays = np.nan_to_num(rays_of_pixels(features.points_px, camera))
    return replace(features, rays_px=rays * camera.focal_length_px)


def follow(
    first: Features, second: Features, *, threshold_px: float, confidence: float, seed: int
) -> FollowedFeatures:
    """Match two frames by mutual nearest neighbours, and count what RANSAC finds to be one rigid motion.

    Equal features and seeds give equal counts, whatever else uses OpenCV's generator.

    - `threshold_px`: distance from its epipolar line (Sampson's) at which a match is still an inlier [px].
    - `confidence`: probability that RANSAC meets a sample free of outliers [1].
    - `seed`: of the samples that RANSAC draws.
    """
    matches = match(first, second)
    inliers = 0
    if len(matches) >= MATCHES_NEEDED:
        consensus = seeded(threshold_px=threshold_px, confidence=confidence, seed=seed)
        before, after = [match.queryIdx for match in matches], [match.trainIdx for match in matches]
        if first.rays_px is not None and second.rays_px is not None:
            inliers = _agreeing_rays(first.rays_px[before], second.rays_px[after], consensus)
        else:
            _, mask = fundamental_matrix(first.points_px[before], second.points_px[after], consensus)
            inliers = 0 if mask is None else int(np.count_nonzero(mask))
    return FollowedFeatures((len(first) + len(second)) / 2, len(matches), inliers)


def _agreeing_rays(first: NDArray[np.float64], second: NDArray[np.float64], consensus: Any) -> int:
    """Number of pairs of (M, 3) rays that agree with one rigid motion of a camera.

    The motion is sought where both look far enough ahead for a flat image. All count whose angle to their
    epipolar plane, either way, is at most the threshold on the axis.
    """
    lengths = np.linalg.norm([first, second], axis=2)
    ahead = ((np.stack([first[:, 2], second[:, 2]]) > _AHEAD * lengths) & (lengths > 0)).all(axis=0)
    if np.count_nonzero(ahead) < MATCHES_NEEDED:
        return 0
    focal_px = float(lengths.max())
    before, after = (
        (rays[ahead, :2] / rays[ahead, 2:] * focal_px).astype(np.float32) for rays in (first, second)
    )
    fundamental, _ = fundamental_matrix(before, after, consensus)
    if fundamental is None or fundamental.shape != (3, 3):
        return 0
    onto_flat = np.diag([1.0, 1.0, 1 / focal_px])  # the third of a flat point is 1, that of a ray z / f
    essential = onto_flat @ fundamental @ onto_flat
    normals, backwards = first @ essential.T, second @ essential
    off = np.abs(np.einsum("ij,ij->i", second, normals))
    farthest = np.maximum(off / np.linalg.norm(normals, axis=1), off / np.linalg.norm(backwards, axis=1))
    return int(np.count_nonzero((farthest <= consensus.threshold) & (lengths > 0).all(axis=0)))


def match(first: Features, second: Features) -> Sequence[Any]:
    """Mutual nearest neighbours of two frames: by differing bits, or by distance of float descriptors."""
    if not (len(first) and len(second)):
        return ()
    norm = cv2.NORM_HAMMING if first.descriptors.dtype == np.uint8 else cv2.NORM_L2
    matches: Sequence[Any] = cv2.BFMatcher(norm, crossCheck=True).match(first.descriptors, second.descriptors)
    return matches


def grey_image(
    image_dn: NDArray[np.uint8] | NDArray[np.uint16], black_level_dn: float, white_level_dn: float
) -> NDArray[np.uint8]:
    """Luminance of a linear frame, stretched so that black is 0 and the white level 255.

    `image_dn`: (H, W, C) uint8 or uint16; one channel, or linear RGB [DN]. `black_level_dn`,
    `white_level_dn`: the file's pedestal and full scale [DN].

    Returns: (H, W) uint8, rounded; what lies below black is 0 [1/255 of full scale].

    >>> frame = np.array([[[64, 64, 64], [2080, 2080, 2080], [4095, 4095, 4095]]], np.uint16)
    >>> grey_image(frame, black_level_dn=64, white_level_dn=4095).tolist()
    [[0, 128, 255]]
    """
    weights = np.array(LUMINANCE_WEIGHTS if image_dn.shape[2] == 3 else (1.0,))
    stretch = 255 / (white_level_dn - black_level_dn)
    affine = np.append(weights * stretch, -black_level_dn * stretch)
    grey = cv2.transform(image_dn, affine[None])  # rounds and saturates to the file's own type
    if grey.dtype != np.uint8:
        np.minimum(grey, 255, out=grey)
    return np.asarray(grey, np.uint8).reshape(image_dn.shape[:2])
