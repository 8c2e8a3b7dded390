"""The response of a camera from exposure times alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

KNOTS = 20
"""Knots of the response, even in the logarithm of the code."""

LINEAR_WITHIN = 0.02
"""Departure from a straight response, as a ratio of light, up to which a camera is taken for linear: lamps
waver by one to two percent from frame to frame."""

_STIFFNESS = 0.3
"""Weight of the response's bends against its misfit; a tenth or ten times as much moves the curve of a
processed bracket by less than two percent between codes that were seen."""

_LEAST_CODE = 0.004
"""Code over full scale below which rounding hides ratios: one of 255."""

_BRIGHT = 0.04
"""Code over full scale from which on logarithms of noisy codes are unbiased: ten of 255, at noise of one."""

_BINS = 60

_MOST_EXPOSURES = 12
"""Exposures whose pairs are compared, spread over their times: pairs of forty tell no more of 20 knots."""


@dataclass(frozen=True, eq=False)
class Response:
    """Response: the light that a code stands for, both over full scale."""

    log_code: NDArray[np.float64]  # (K,) rising logarithms of codes over full scale, the last 0
    log_light: NDArray[np.float64]
    """(K,) logarithms of light, that of the full code 0; equal to `log_code` for a linear camera."""
    linear: bool  # whether a straight line fitted, as far as lamps are steady

    def light_of(self, code: NDArray[np.floating]) -> NDArray[np.float64]:
        """Light over that of the full code, of codes over full scale; straight on below the first knot."""
        log = np.log(np.maximum(code, 1e-6))
        bend = np.interp(log, self.log_code, self.log_light - self.log_code)
        return np.asarray(np.where(code > 0, np.exp(log + bend), 0.0))


def fit_response(
    codes: Sequence[NDArray[np.floating]], exposures_s: Sequence[float], usable: Sequence[NDArray[np.bool_]]
) -> Response:
    """Find the response at which the light of every pixel grows as its exposure time.

    Codes c at the times s and t of one pixel obey g(c_t) - g(c_s) = log(t / s), with g the logarithm of light
    (Debevec and Malik 1997, "Recovering high dynamic range radiance maps from photographs", eq. 2). Pixels
    are gathered by their code in one exposure, and what is fitted is how g departs from the logarithm of the
    code, so that a linear camera is the solution that nothing bends.

    `codes`: (P,) codes above the pedestal over full scale of the same pixels, one array per exposure.
    `usable`: (P,) for each exposure where a code is neither clipped nor lost in rounding.
    """
    chosen = np.argsort(exposures_s, kind="stable")
    if len(chosen) > _MOST_EXPOSURES:
        chosen = chosen[np.linspace(0, len(chosen) - 1, _MOST_EXPOSURES).round().astype(int)]
    pairs = [
        pair
        for s in chosen
        for t in chosen
        if s < t and exposures_s[s] != exposures_s[t]
        for pair in _pairs(codes[s], codes[t], usable[s] & usable[t], np.log(exposures_s[t] / exposures_s[s]))
    ]
    knots = np.linspace(np.log(_LEAST_CODE), 0.0, KNOTS)
    straight = Response(knots, knots, linear=True)
    if len(pairs) < 4:
        return straight
    low, high, ratio, weight = np.array(pairs).T
    departure = ratio - (high - low)
    rows = (_hats(high, knots) - _hats(low, knots)) * np.sqrt(weight)[:, None]
    bends = np.diff(np.eye(KNOTS), n=2, axis=0) * _STIFFNESS * np.sqrt(weight.sum())
    anchor = np.zeros((1, KNOTS))
    anchor[0, -1] = 1e3  # the full code is the full light
    left = np.vstack([rows, bends, anchor])
    right = np.concatenate([departure * np.sqrt(weight), np.zeros(KNOTS - 2 + 1)])
    bend, *_ = np.linalg.lstsq(left, right, rcond=None)
    bright = low > np.log(_BRIGHT)
    if not bright.any() or np.ptp(_hats(low[bright], knots) @ bend) < 2 * LINEAR_WITHIN:
        return straight
    return Response(knots, np.maximum.accumulate(knots + bend - bend[-1]), linear=False)


def _pairs(
    first: NDArray[np.floating], second: NDArray[np.floating], usable: NDArray[np.bool_], log_ratio: float
) -> list[tuple[float, float, float, float]]:
    """Middle codes of two exposures (logarithms), bin by bin of their product, with weights.

    Bins of either code alone would favour noise of one sign in it.
    """
    usable = usable & (first > _LEAST_CODE) & (second > _LEAST_CODE)
    if usable.sum() < _BINS:
        return []
    low, high = np.log(first[usable]), np.log(second[usable])
    along = low + high
    edges = np.linspace(along.min(), along.max() + 1e-9, _BINS + 1)
    which = np.searchsorted(edges, along, side="right") - 1
    found = []
    for each in np.unique(which):
        inside = which == each
        count = int(inside.sum())
        if count >= 5:
            low_middle, high_middle = float(np.median(low[inside])), float(np.median(high[inside]))
            found.append((low_middle, high_middle, log_ratio, min(count, 500.0) * np.exp(low_middle / 2)))
    return found


def _hats(x: NDArray[np.float64], knots: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, K) weights of the knots that linear interpolation at x takes."""
    step = knots[1] - knots[0]
    return np.maximum(0.0, 1 - np.abs(np.clip(x, knots[0], knots[-1])[:, None] - knots[None, :]) / step)
