"""Mixing of channels: the matrix from expected to real colours, and patches of a chart."""

from __future__ import annotations

from collections.abc import Iterator
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture
from tacos_gap.statistics.block import Sample, StatisticBlock, expected_signal

_LEAST_SPREAD = 0.01
"""Spread of colours, over full scale, below which a matrix cannot be told."""

_MATRIX = 0.005
"""Equivalence margin of an entry of the matrix."""

_LEAST_PATCH_DN = 0.3
"""Least equivalence margin of a patch [DN]."""

_FEWEST = 70
"""Fewest pixels that a matrix is measured in."""


def colour_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """The least-squares matrix from expected to real linear colours; mean residuals of chart patches."""
    if len(sample.channels) != 3 or sample.capture.kind == "dark" or sample.capture.own_light:
        return
    black = np.float32(sample.capture.context.black_level_dn)
    white = np.float32(sample.capture.context.white_level_dn - black)
    if has_colours(sample.capture):
        used = _used(sample.capture)
        expected = (sample.reference.reshape(-1, 3)[used] - black) / white
        real = (sample.mean.reshape(-1, 3)[used] - black) / white
        matrix = np.linalg.lstsq(expected, real, rcond=None)[0].T
        at = [{"from": "RGB"[column], "to": "RGB"[row]} for row in range(3) for column in range(3)]
        margin = np.hypot(_MATRIX, sample.capture.target_within / 2)  # of two dozen patches
        yield StatisticBlock("colour_matrix", "isp", matrix.ravel(), at, margin)
    if sample.capture.patches is not None:
        boxes, _ = sample.capture.patches
        places = [{"patch": int(k), "channel": c} for k in range(len(boxes)) for c in "RGB"]
        margins = np.hypot(_LEAST_PATCH_DN, sample.capture.target_within * _means_of(boxes, sample.signal))
        yield StatisticBlock("patches", "isp", _means_of(boxes, sample.residual), places, margins)


def _means_of(boxes: NDArray[np.int64], image: NDArray[np.float32]) -> NDArray[np.float64]:
    """(3 P,) means of patches of an (H, W, 3) image, channel by channel of each."""
    means = [image[y : y + h, x : x + w].mean(axis=(0, 1)) for x, y, w, h in boxes]
    return np.concatenate(means).astype(np.float64)


_COLOURFUL: WeakKeyDictionary[RealCapture, bool] = WeakKeyDictionary()


def has_colours(capture: RealCapture) -> bool:
    if capture not in _COLOURFUL:
        _COLOURFUL[capture] = _are_colourful(capture, _used(capture))
    return _COLOURFUL[capture]


def _are_colourful(capture: RealCapture, used: NDArray[np.int64]) -> bool:
    if len(used) < _FEWEST:
        return False
    context = capture.context
    colours = expected_signal(capture).reshape(-1, 3)[used].astype(np.float64)
    colours /= context.white_level_dn - context.black_level_dn
    return bool(np.linalg.eigvalsh(np.cov(colours.T))[0] > _LEAST_SPREAD**2)


_USED: WeakKeyDictionary[RealCapture, NDArray[np.int64]] = WeakKeyDictionary()
_STEP = 7
_MOST = 1 << 16


def _used(capture: RealCapture) -> NDArray[np.int64]:
    """Every seventh pixel, or fewer, that counts and is expected well below saturation, as flat indices."""
    if capture not in _USED:
        context = capture.context
        white = 0.9 * (context.white_level_dn - context.black_level_dn)
        usable = np.flatnonzero(capture.valid & (expected_signal(capture).max(axis=-1) < white))
        _USED[capture] = usable[:: max(_STEP, usable.size // _MOST)]
    return _USED[capture]
