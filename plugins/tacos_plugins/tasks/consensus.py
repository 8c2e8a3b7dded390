"""Random samples that agree: OpenCV's RANSAC, seeded."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray


def seeded(*, threshold_px: float, confidence: float, seed: int) -> cv2.UsacParams:
    """Settings of a search for the model that most matches agree with; equal seeds draw equal samples.

    - `threshold_px`: distance from the model at which a match is still an inlier [px].
    - `confidence`: probability that a sample free of outliers is met [1].
    - `seed`: of the samples drawn, whatever else uses OpenCV's generator.

    Source: Raguram et al. 2013, "USAC: a universal framework for random sample consensus", as OpenCV
    implements it.
    """
    params = cv2.UsacParams()
    params.threshold = threshold_px
    params.confidence = confidence
    params.randomGeneratorState = seed
    return params


def fundamental_matrix(
    before_px: NDArray[np.float32], after_px: NDArray[np.float32], *search: Any
) -> tuple[NDArray[np.float64] | None, NDArray[np.uint8] | None]:
    """The fundamental matrix that most of (M, 2) matches agree with, and which do; None where there is none.

    `search`: what `seeded` gives, or OpenCV's name of a method with its threshold and confidence.
    """
    try:
        found, agreeing = cv2.findFundamentalMat(before_px, after_px, *search)
    except cv2.error as error:  # OpenCV 5 raises where no sample has a model; version 4 returned none
        if "model.empty()" not in str(error):
            raise
        found = None
    if found is None:
        return None, None
    return np.asarray(found, np.float64), np.asarray(agreeing, np.uint8)
