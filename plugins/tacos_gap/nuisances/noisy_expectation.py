"""The noise of an expectation that is itself the mean of a few noisy frames.

What is given is x = t + e: the true expectation and noise that stays. Simulated frames hold e as if it were
detail, real ones do not; and real less expected holds -e as if it were a pattern of the sensor, simulated
less expected does not. So real frames are given noise of their own of the same size, e', and what simulated
frames are compared with is given twice its variance, e''. Then both hold as much detail (t + e, t + e') and
as much pattern (e' - e, -e''), in every statistic.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture


def expectation_noise(
    capture: RealCapture, rng: np.random.Generator, share: float
) -> NDArray[np.float32] | None:
    """Another draw of the expectation's noise; None where it has none.

    Parameters
    ----------
    capture
        With expected values.
    rng
        Where the draw comes from.
    share
        Its variance, over that of one frame.

    Returns
    -------
    NDArray
        (1 or N, H, W, C) [DN].
    """
    if not share:
        return None
    assert capture.expected_dn is not None
    signal = capture.expected_dn - np.float32(capture.context.black_level_dn)
    sigma = np.sqrt(capture.noise.variance_dn2(signal) * np.float32(share))
    return np.asarray(rng.standard_normal(signal.shape, dtype=np.float32) * sigma)
