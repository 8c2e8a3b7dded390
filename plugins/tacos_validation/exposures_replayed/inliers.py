"""Features that consecutive frames share, as recordings are scored in publications.

The fundamental matrix comes from OpenCV's RANSAC, whose samples are the same in each call.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import pairwise
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_plugins.tasks.consensus import fundamental_matrix
from tacos_plugins.tasks.followed_features import MATCHES_NEEDED, Features, extract, match

THRESHOLD_PX = 3.0

Detector = Literal["orb", "sift"]

DETECTORS: Mapping[Detector, Callable[[int], Any]] = {
    "orb": lambda features: cv2.ORB.create(nfeatures=features),
    "sift": lambda features: cv2.SIFT.create(nfeatures=features),
}


def inliers_of_pairs(
    frames_dn: Iterable[NDArray[np.uint16]],
    *,
    bits: int,
    conversion: int | None,
    detector: Detector,
    features: int,
) -> NDArray[np.float64]:
    """(N - 1,) inliers of one fundamental matrix for each pair of consecutive (H, W) frames.

    `conversion`: OpenCV's code from the mosaic to grey; None where there is no mosaic.
    """
    finds = DETECTORS[detector](features)
    found = []
    for frame in frames_dn:
        grey = frame if conversion is None else cv2.cvtColor(frame, conversion)
        found.append(extract(finds, np.right_shift(np.asarray(grey, np.uint16), bits - 8).astype(np.uint8)))
    pairs = pairwise(found)
    return np.array([_inliers(first, second) for first, second in pairs], np.float64)


def _inliers(first: Features, second: Features) -> int:
    matches = match(first, second)
    if len(matches) < MATCHES_NEEDED:
        return 0
    _, mask = fundamental_matrix(
        first.points_px[[match.queryIdx for match in matches]],
        second.points_px[[match.trainIdx for match in matches]],
        cv2.FM_RANSAC,
        THRESHOLD_PX,
        0.99,
    )
    return 0 if mask is None else int(np.count_nonzero(mask))
