"""Traces that a camera's software leaves in its files, which no lens and no sensor makes.

They are looked for without a model of the software: makers smooth and sharpen each in their own way. Where no
family of effects fits a gap, files that bear such traces are its likeliest cause.
"""

from __future__ import annotations

from collections.abc import Sequence
from warnings import catch_warnings, simplefilter

import numpy as np

from tacos_gap.captures.capture import RealCapture
from tacos_gap.captures.targets.slanted_edge import find_edge

SMOOTHED_GREY, SMOOTHED_COLOUR = 0.25, 0.45
"""Correlation of the noise of neighbours from which on it was smoothed: crosstalk of pixels makes .1 at most,
bilinear demosaicing .25 to .35 in colour."""

OVERSHOOT = 0.04
"""Share of an edge's contrast by which it overshoots from which on it was sharpened: light never does."""

_LEAST_DN2 = 0.3
"""Variance of noise that rounding leaves its correlations to [DN^2]."""

_STILL = ("dark", "flat", "edge", "chart", "bracket", "scene")


def traces_of_processing(captures: Sequence[RealCapture]) -> list[str]:
    smoothed = [(found, c.id) for c in captures if (found := _smoothing(c)) is not None]
    sharpened = [(found, c.id) for c in captures if (found := _overshoot(c)) is not None]
    said = []
    if smoothed:
        most, name = max(smoothed)
        said.append(f"noise was smoothed (that of neighbours correlates by {most:.2f} in {name})")
    if sharpened:
        most, name = max(sharpened)
        said.append(f"edges were sharpened (they overshoot by {most:.0%} in {name})")
    return said


def _smoothing(capture: RealCapture) -> float | None:
    """Correlation of the noise of horizontal and vertical neighbours, where it is more than sensors make."""
    if capture.frames < 2 or capture.kind not in _STILL or capture.context.cfa is not None:
        return None
    colour = capture.real_dn.shape[-1] == 3
    first, second = (frame[..., frame.shape[-1] // 2] for frame in capture.real_dn[:2])
    context = capture.context
    inside = (first > context.black_level_dn * 0.5) & (first < 0.95 * context.white_level_dn)
    noise = np.where(inside, first - second, np.nan)
    with catch_warnings():
        simplefilter("ignore", RuntimeWarning)  # lines of nothing but clipped pixels
        for axis in (1, 0):  # a lamp that flickers, and noise of lines, are no noise of pixels
            noise = noise - np.nanmean(noise, axis=axis, keepdims=True)
    variance = float(np.nanmean(noise**2)) if inside.mean() > 0.2 else 0.0
    if variance / 2 < _LEAST_DN2:
        return None
    beside = min(float(np.nanmean(noise[:, 1:] * noise[:, :-1])), float(np.nanmean(noise[1:] * noise[:-1])))
    correlation = beside / variance
    return correlation if correlation > (SMOOTHED_COLOUR if colour else SMOOTHED_GREY) else None


def _overshoot(capture: RealCapture) -> float | None:
    """Overshoot of a straight edge on both sides over its contrast, where that is more than noise."""
    if capture.kind != "edge":
        return None
    mean = capture.real_dn.mean(axis=0)
    image = np.asarray(mean[..., mean.shape[-1] // 2], np.float64)
    edge = find_edge(image)
    if edge is None:
        return None
    distance = edge.distance_px(image.shape)
    near = np.abs(distance) < 14
    bins = np.arange(-14, 14.5, 0.5)
    counts = np.histogram(distance[near], bins)[0]
    profile = np.histogram(distance[near], bins, weights=image[near])[0] / np.maximum(counts, 1)
    middle = (bins[:-1] + bins[1:]) / 2
    dark, bright = (np.median(profile[(sign * middle > 8) & (counts > 0)]) for sign in (-1, 1))
    far = (np.abs(middle) > 8) & (counts > 0)
    scatter = float(np.std((profile - np.where(middle > 0, bright, dark))[far]))
    close = (np.abs(middle) > 0.5) & (np.abs(middle) < 6) & (counts > 0)
    above = float(np.max(profile[close & (middle > 0)])) - bright
    below = dark - float(np.min(profile[close & (middle < 0)]))
    if bright <= dark or min(above, below) < 5 * scatter:
        return None
    share = float(min(above, below) / (bright - dark))
    return share if share > OVERSHOOT else None
