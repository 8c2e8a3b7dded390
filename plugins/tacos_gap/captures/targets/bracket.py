"""A bracket: one view at several exposure times, which tell the light of every pixel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.capture import RealCapture
from tacos_gap.captures.targets.response import Response, fit_response

_SAMPLES = 40_000
"""Pixels the response is fitted to."""

_SPIKE_SHARE = 0.001
"""Share of the pixels at the highest codes from which on these are where the camera stops."""


@dataclass(frozen=True, eq=False)
class Bracket:
    """Response and light measured from a bracket."""

    response: Response  # from light to codes
    rate: NDArray[np.float64]  # (H, W, C) light per second over that of the full code [1/s]
    known: NDArray[np.bool_]  # (H, W) pixels that some exposure shows unclipped in every channel


def measure_bracket(captures: Sequence[RealCapture]) -> Bracket:
    """Response and light of captures of one view that differ in their exposure time alone."""
    black = captures[0].context.black_level_dn
    span = captures[0].context.white_level_dn - black
    codes = [(each.real_dn.mean(axis=0) - black) / span for each in captures]
    times_s = [each.context.exposure_s for each in captures]
    top = _highest(codes)
    usable = [(code < 0.97 * top) & (code > 0) for code in codes]
    stride = max(1, codes[0].size // _SAMPLES)
    response = fit_response(
        [code.ravel()[::stride] for code in codes], times_s, [use.ravel()[::stride] for use in usable]
    )
    total, weights = np.zeros(codes[0].shape), np.zeros(codes[0].shape)
    for code, time_s, use in zip(codes, times_s, usable, strict=True):
        weight = np.where(use, time_s, 0.0)  # photons collected: the least noisy mean of rates
        total += weight * response.light_of(code) / time_s
        weights += weight
    shortest = int(np.argmin(times_s))
    longest = int(np.argmax(times_s))
    dark = codes[longest] <= 0
    clipped = (weights == 0) & ~dark
    rate = np.where(weights > 0, total / np.maximum(weights, 1e-12), 0.0)
    rate[clipped] = response.light_of(codes[shortest])[clipped] / times_s[shortest]
    return Bracket(response, rate, ~clipped.any(axis=-1))


def expected_of(bracket: Bracket, capture: RealCapture) -> NDArray[np.float32]:
    """(1, H, W, C) linear file values that the light gives in the time of a capture, not clipped [DN]."""
    context = capture.context
    span = context.white_level_dn - context.black_level_dn
    linear = bracket.rate * context.exposure_s * span + context.black_level_dn
    return np.asarray(linear[None], np.float32)


def _highest(codes: Sequence[NDArray[np.floating]]) -> float:
    """The code over full scale at which the camera stops: the highest, where many pixels share it."""
    highest = max(float(code.max()) for code in codes)
    shared = max(float(np.mean(code > 0.985 * highest)) for code in codes)
    return highest if shared > _SPIKE_SHARE else max(highest / 0.97 + 1e-6, 1.0)
