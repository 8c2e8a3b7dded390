"""Controls of a camera that are still settling as a sequence begins, and what of it captures show."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Captures, ObservedCapture, of_kind

FEWEST_FRAMES = 3
"""Frames of a sequence that tell a drift from two frames that differ."""

LEAST_CHANGE = 0.01
"""Change over a sequence below which nothing is suspected of it, relative."""


def settling(first: float, lag_frames: float, start: int, count: int) -> NDArray[np.float64]:
    """Factors that come to 1 exponentially, in stops.

    - `first`: the factor of the episode's first frame [1].
    - `lag_frames`: frames after which 63 % of the way is gone; all of it after one frame if 0 [frame].
    - `start`, `count`: the first frame that is asked for, counted in its episode, and how many.

    Returns: (count,) float64 [1].

    >>> settling(4.0, lag_frames=1 / math.log(2), start=0, count=3).round(3).tolist()
    [4.0, 2.0, 1.414]
    """
    frames = np.arange(start, start + count)
    left = np.exp(-frames / lag_frames) if lag_frames else (frames == 0).astype(float)
    return np.exp2(math.log2(first) * left)


LAGS_FRAMES = np.geomspace(0.3, 30.0, 41)
"""Lags that are tried on what captures show [frame]."""


def settling_of(factors: NDArray[np.float64]) -> tuple[float, float]:
    """First factor, over the settled one, and lag [frame] that come nearest to (N,) factors, in stops.

    >>> first, lag_frames = settling_of(90.0 * settling(0.7, 1.5, start=0, count=6))
    >>> round(first, 2), round(lag_frames, 1)
    (0.7, 1.5)
    """
    stops, count = np.log2(factors), len(factors)
    best = (np.inf, 1.0, 1.0)
    for lag_frames in LAGS_FRAMES.tolist():
        model = np.stack([np.log2(settling(2.0, lag_frames, 0, count)), np.ones(count)], axis=1)
        solution, *_ = np.linalg.lstsq(model, stops, rcond=None)
        rest = float(np.sum((stops - model @ solution) ** 2))
        best = min(best, (rest, float(2 ** solution[0]), lag_frames))
    return best[1], best[2]


def sequences(captures: Captures) -> list[ObservedCapture]:
    """Captures of a sequence that are long enough to drift."""
    return [
        capture
        for capture in of_kind(captures, "sequence")
        if capture.frames >= FEWEST_FRAMES and capture.expected_dn is not None
    ]


def a_drift_could_show(captures: Captures) -> bool:
    """True if a sequence is long enough to show one."""
    return bool(sequences(captures))


def means_dn(capture: ObservedCapture) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(N, C) mean signal of each frame, real and expected, above the pedestal [DN]."""
    assert capture.expected_dn is not None
    black, valid = capture.context.black_level_dn, capture.valid
    real = capture.real_dn[:, valid].mean(axis=1, dtype=np.float64) - black
    expected = capture.expected_dn[:, valid].mean(axis=1, dtype=np.float64) - black
    return np.maximum(real, 1e-3), np.broadcast_to(np.maximum(expected, 1e-3), real.shape)
