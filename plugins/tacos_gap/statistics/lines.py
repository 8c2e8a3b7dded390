"""Single rows and columns that stand out: defects, and the extremes of patterns."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from tacos_gap.statistics.block import Sample, StatisticBlock, mean_signal
from tacos_gap.statistics.line_means import line_means, over_channels
from tacos_plugins.effects.line_defects import NEIGHBOURS

_OFFSET_DN = 0.08
_RELATIVE = 0.003
_LUCK = 0.2
"""Relative spread of the largest of many lines from one specimen of a sensor to the next."""


def line_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Mean of the brightest and of the darkest row and column less those around it, in even fields.

    Pixels that are hot by themselves are taken out by a median along the line, which keeps lines that are bad
    over a part of their length only.
    """
    if not sample.capture.shows_patterns:
        return
    plane = over_channels(sample.residual_as_taken)
    plane = plane if sample.valid.all() else np.where(sample.valid, plane, 0)
    extremes, at = [], []
    for axis, name in ((0, "column"), (1, "row")):
        offsets = line_offsets(plane, axis)
        extremes += [offsets.max(), offsets.min()]
        at += [{"line": f"brightest {name}"}, {"line": f"darkest {name}"}]
    values = np.array(extremes, float)
    signal = float(np.abs(mean_signal(sample.capture)).mean())
    margin = np.hypot(_OFFSET_DN, _RELATIVE * signal)
    yield StatisticBlock("line_offset", "pixel", values, at, np.hypot(margin, _LUCK * values))


def line_offsets(plane: NDArray[np.floating], axis: int) -> NDArray[np.float64]:
    """Mean of each line along an axis of an (H, W) image, less the median of those around it [DN]."""
    along = plane if axis == 0 else np.ascontiguousarray(plane.T)
    before, here, after = along[:-2], along[1:-1], along[2:]
    steady = np.maximum(np.minimum(before, here), np.minimum(np.maximum(before, here), after))
    profile = line_means(steady[..., None], 0)[:, 0].astype(np.float64)
    return np.asarray(profile - median_filter(profile, NEIGHBOURS, mode="nearest"))
