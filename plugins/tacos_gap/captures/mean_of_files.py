"""Expectations that are means of a few noisy files: where they are bright, and where they say too little."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.capture import RealCapture

AVERAGED = 9
"""Side of the window in which a noisy expectation is averaged before its level counts [px]."""

REACH_SPREADS = 2.5
"""Distance from white, in standard deviations of a frame's noise, within which a mean of files is off by
more than a hundredth of one: E[max(x - white, 0)] of a Gaussian is 0.002 of its deviation there."""


def averaged_expectation(capture: RealCapture) -> NDArray[np.float32]:
    """(H, W, C) mean of the expectation over frames, and over a window of pixels that count [DN].

    Of a mosaic, over those of the same colour. Pixels that are chosen by their noise are not as bright as it
    says (regression to the mean); by an average they may be chosen.
    """
    import cv2

    assert capture.expected_dn is not None
    step = 2 if capture.context.cfa else 1
    kernel = np.zeros((step * (AVERAGED - 1) + 1,) * 2, np.float32)
    kernel[::step, ::step] = 1
    counted = capture.valid[..., None].astype(np.float32)
    level = np.asarray(capture.expected_dn.mean(axis=0) * counted, np.float32)
    total, count = (
        cv2.filter2D(each, cv2.CV_32F, kernel, borderType=cv2.BORDER_REFLECT_101).reshape(each.shape)
        for each in (level, counted)
    )
    return np.asarray(total / np.maximum(count, 1), np.float32)


def noise_of_average(capture: RealCapture) -> NDArray[np.float64]:
    """(C,) standard deviation of the noise that is left in `averaged_expectation` at the mean level [DN]."""
    assert capture.expected_dn is not None
    signal = capture.expected_dn.mean(axis=(0, 1, 2)) - np.float32(capture.context.black_level_dn)
    variance = np.broadcast_to(capture.noise.variance_dn2(signal), signal.shape)
    return np.asarray(np.sqrt(variance / capture.expected_frames) / AVERAGED, np.float64)


def without_clipped_expectation(capture: RealCapture) -> RealCapture:
    """The capture with pixels masked whose expectation is a mean of files that white has cut off.

    Such a mean is too low by a part of the noise, and hardly noisy: cut off again by the simulation it is
    neither as bright nor as often white as real files are. What is expected above white is no mean of files,
    but scaled from other exposures, and stays.
    """
    if not capture.expected_frames or capture.expected_dn is None:
        return capture
    white = capture.context.white_level_dn
    full = np.array([white - capture.context.black_level_dn], np.float32)
    reach = REACH_SPREADS * np.sqrt(capture.noise.variance_dn2(full))
    levels = [averaged_expectation(capture)]
    if capture.is_structured:  # glints and edges are lost in the average, which of even light chooses fairly
        levels += list(capture.expected_dn)
    cut_off = np.any([(level >= white - reach) & (level <= white) for level in levels], axis=(0, -1))
    return replace(capture, valid=capture.valid & ~cut_off)
