"""Noise of a camera from pairs of its own frames, whatever the light was."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.capture import Noise, RealCapture
from tacos_gap.captures.noise_estimate import thinned, without_lines
from tacos_gap.captures.rounding import BeforeRounding, are_whole, before_rounding
from tacos_plugins.effects.code_steps import code_step_dn

LEAST_SPAN = 0.1
"""Range of levels over full scale below which a slope is not told from its intercept."""

_BINS = 16
_LEAST_PIXELS = 200
_LEAST_WIDTH_DN = 2.0
"""Of a bin: frames whose mean is one whole number differ by even numbers alone."""

_ROUNDS = 4
_CLIPPED = 0.95
_CUT_OFF = 0.01
"""Share of a dark at 0 from which on its mean lies above its level."""


def pooled_noise(captures: Sequence[RealCapture]) -> Noise | None:
    """One line of variance against signal for all captures of a gain, per channel.

    Half the variance of the difference of two frames, bin by bin of their mean: the light, its shading and
    the pattern of the sensor cancel (EMVA 1288 release 4, 6.6; Janesick 2007, "Photon Transfer"). Signal is
    what lies above the darks, where there are some: the pedestal that is believed may be what is wrong.

    Returns noise with ``known`` False, as it says nothing of the simulator; None where captures span too few
    levels.
    """
    still = [each for each in captures if each.frames > 1 and each.kind != "sequence"]
    if not still:
        return None
    step = code_step_dn(still)
    step_dn = step.value if step else 1.0
    photon, thermal = [], []
    for channel, zero in enumerate(zero_levels_dn(captures).tolist()):
        found = [point for each in still for point in _points(each, channel, zero, step_dn)]
        points = np.array(found).reshape(-1, 3)
        span = still[0].context.white_level_dn - still[0].context.black_level_dn
        if len(points) < 2 or np.ptp(points[:, 0]) < LEAST_SPAN * span:
            return None
        signal, variance, count = points.T
        weight = np.sqrt(count) / np.maximum(variance, 0.05)
        slope, intercept = np.polyfit(signal, variance, 1, w=weight)
        photon.append(max(float(slope), 0.0))
        thermal.append(max(float(intercept), 0.01))
    return Noise(tuple(photon), tuple(thermal), known=False)


def zero_levels_dn(captures: Sequence[RealCapture]) -> NDArray[np.float64]:
    """(C,) levels of the files without light: those of the shortest dark, mean by mean [DN].

    The believed pedestal where there is no dark, or where its noise is cut off at 0.
    """
    darks = [capture for capture in captures if capture.kind == "dark"]
    if darks:
        shortest = min(darks, key=lambda each: each.context.exposure_s)
        seen = shortest.real_dn[:, shortest.valid]
        if seen.size and np.mean(seen <= 0) < _CUT_OFF:
            return np.asarray(seen.mean(axis=(0, 1), dtype=np.float64))
    return np.full(captures[0].real_dn.shape[-1], captures[0].context.black_level_dn, np.float64)


def _points(
    capture: RealCapture, channel: int, zero_dn: float, step_dn: float
) -> list[tuple[float, float, float]]:
    """Signal above `zero_dn`, variance and number of pixels of each bin of level [DN, DN^2, 1].

    All is counted in the codes of a coarser converter meanwhile, `step_dn` apart: it rounds by these. Pixels
    count as far as the variance of their codes tells that of the noise (`BeforeRounding.steepness`).
    """
    pair = thinned(capture.real_dn[:2, ..., channel : channel + 1])
    if step_dn > 1:
        pair = np.rint(pair / step_dn)
    first, second = pair[..., 0].astype(np.float64)
    zero = zero_dn / step_dn
    mean = (first + second) / 2 - zero
    span = capture.context.white_level_dn / step_dn - zero
    usable = thinned(capture.valid[..., None])[..., 0] & (mean < _CLIPPED * span)
    if zero_dn < 1:
        usable &= (first > 0) & (second > 0)  # what is cut off at 0 has lost half of its noise
    level, difference = mean[usable], without_lines(first - second, usable)[usable]
    if level.size < _LEAST_PIXELS:
        return []
    difference = difference - np.median(difference)  # a lamp that wavered between the two
    edges = _bin_edges(level)
    which = np.searchsorted(edges[1:-1], level, side="right")
    rounded = are_whole(pair)

    def point(inside: NDArray[np.bool_]) -> tuple[float, float, float]:
        signal = float(level[inside].mean())
        noise = BeforeRounding(_robust_variance(difference[inside]) / 2, 1.0)
        if rounded:
            noise = before_rounding(noise.variance_dn2, signal + zero)
        return signal * step_dn, noise.variance_dn2 * step_dn**2, float(inside.sum()) * noise.steepness**2

    bins = (which == bin_ for bin_ in range(len(edges) - 1))
    return [point(inside) for inside in bins if inside.sum() >= _LEAST_PIXELS]


def _bin_edges(level: NDArray[np.float64]) -> list[float]:
    """Borders of bins that hold about as many pixels each, and several codes."""
    borders = np.quantile(level, np.linspace(0, 1, _BINS + 1)).tolist()
    edges = borders[:1]
    for border in borders[1:-1]:
        if border - edges[-1] >= _LEAST_WIDTH_DN and borders[-1] - border >= _LEAST_WIDTH_DN:
            edges.append(border)
    return [*edges, borders[-1]]


def _robust_variance(values: NDArray[np.float64]) -> float:
    """Variance of what is within four spreads: moving leaves and hot pixels stay out."""
    spread = max(1.4826 * float(np.median(np.abs(values))), 1.0)
    for _ in range(_ROUNDS):  # half of the codes of a dark are alike: their median deviation is no spread
        variance = float(np.mean(values[np.abs(values) <= 4 * spread] ** 2))
        spread = max(variance**0.5, 1.0)
    return variance
