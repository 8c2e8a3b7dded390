"""Where the mean of a few noisy files says too little of the light, as white has cut some of them off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tacos_gap.captures.capture import RealCapture

REACH_SPREADS = 2.5
"""Distance from white, in standard deviations of a frame's noise, within which a mean of files is off by
more than a hundredth of one: E[max(x - white, 0)] of a Gaussian is 0.002 of its deviation there."""


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
    cut_off = (capture.expected_dn >= white - reach) & (capture.expected_dn <= white)
    return replace(capture, valid=capture.valid & ~cut_off.any(axis=(0, -1)))
