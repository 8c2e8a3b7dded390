"""The noise of an expectation that is itself the mean of a few noisy frames.

What is given is x = t + e: the true expectation and noise that stays. Simulated frames hold e as if it were
detail, real ones do not; and real less expected holds -e as if it were a pattern of the sensor, simulated
less expected does not. So real frames are given noise of their own of the same size, e', and what simulated
frames are compared with is given twice its variance, e''. Then both hold as much detail (t + e, t + e') and
as much pattern (e' - e, -e''), in every statistic.

Where files end, at black, at white or where pixels are full, light and its noise no longer show. So e' is
added to what a pixel would have shown beyond the end, which is drawn, and ends there again.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from tacos_gap.captures import RealCapture

FULL_SHARE = 0.01
"""Share of pixels at the largest value from which on that value is where pixels are full: by noise alone a
hundredth of a frame does not share its last code."""

_LAST_CODES_DN = 2.0


def expectation_noise(
    capture: RealCapture, rng: np.random.Generator, share: float
) -> NDArray[np.float32] | None:
    """Another draw of the expectation's noise; None where it has none.

    - `share`: its variance, over that of one frame.

    Returns: (1 or N, H, W, C) [DN].
    """
    if not share:
        return None
    assert capture.expected_dn is not None
    signal = capture.expected_dn - np.float32(capture.context.black_level_dn)
    sigma = np.sqrt(capture.noise.variance_dn2(signal) * np.float32(share))
    return np.asarray(rng.standard_normal(signal.shape, dtype=np.float32) * sigma)


def with_noise_of_expectation(
    capture: RealCapture, rng: np.random.Generator, share: float
) -> NDArray[np.float32] | None:
    """(N, H, W, C) the real frames with e' of a `share`, see above; None without a share [DN]."""
    added = expectation_noise(capture, rng, share)
    if added is None:
        return None
    low, high = ends_dn(capture)
    beyond = _beyond_the_ends(capture, rng, low, high)
    return np.asarray(np.clip(beyond + added, low, high), np.float32)


def ends_dn(capture: RealCapture) -> tuple[float, float]:
    """Least and largest value that the files can have, or their pixels are full at [DN]."""
    top = float(capture.real_dn.max())
    full = np.mean(capture.real_dn >= top - _LAST_CODES_DN) > FULL_SHARE
    return 0.0, top if full else max(capture.context.white_level_dn, top)


def _beyond_the_ends(
    capture: RealCapture, rng: np.random.Generator, low: float, high: float
) -> NDArray[np.float32]:
    """(N, H, W, C) the real frames with values at their ends drawn from the noise beyond these [DN].

    Values are of a Gaussian around the expectation, of which the end is known to have been passed: the
    inverse of its distribution at a uniform draw.
    """
    assert capture.expected_dn is not None
    frames = capture.real_dn.copy()
    for end, side in ((low, -1.0), (high, 1.0)):
        at = frames <= end if side < 0 else frames >= end
        if not at.any():
            continue
        expected = np.broadcast_to(capture.expected_dn, frames.shape)
        signal = expected - np.float32(capture.context.black_level_dn)
        mean = side * expected[at].astype(np.float64)
        sigma = np.sqrt(np.broadcast_to(capture.noise.variance_dn2(signal), frames.shape)[at]) + _LEAST_DN
        share_beyond = np.maximum(ndtr((mean - side * end) / sigma), _LEAST_SHARE)
        drawn = mean - sigma * ndtri(share_beyond * (1 - rng.random(mean.shape)))
        frames[at] = side * np.maximum(drawn, side * end)
    return frames


_LEAST_DN, _LEAST_SHARE = 1e-3, 1e-12
