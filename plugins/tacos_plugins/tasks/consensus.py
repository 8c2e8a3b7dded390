"""Random samples that agree: OpenCV's RANSAC, seeded."""

from __future__ import annotations

import cv2


def seeded(*, threshold_px: float, confidence: float, seed: int) -> cv2.UsacParams:
    """Settings of a search for the model that most matches agree with; equal seeds draw equal samples.

    Parameters
    ----------
    threshold_px
        Distance from the model at which a match is still an inlier [px].
    confidence
        Probability that a sample free of outliers is met [1].
    seed
        Of the samples drawn, whatever else uses OpenCV's generator.

    References
    ----------
    Raguram et al. 2013, "USAC: a universal framework for random sample consensus", as OpenCV implements it.
    """
    params = cv2.UsacParams()
    params.threshold = threshold_px
    params.confidence = confidence
    params.randomGeneratorState = seed
    return params
