"""The values themselves: clipping, piled-up and missing codes."""

from __future__ import annotations

from collections.abc import Iterator
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture
from tacos_gap.statistics.block import Sample, StatisticBlock
from tacos_gap.statistics.sampled import CODE_SAMPLES, sampled

PERIODS = (2, 3, 4, 5, 6, 8)
"""Steps between used codes that are looked for [DN]."""

_DEEPEST_DN = 4096
"""Files deeper than this have codes to spare; combs are not looked for."""


_PLACES: WeakKeyDictionary[RealCapture, dict[tuple[int, ...], NDArray[np.int64]]] = WeakKeyDictionary()


def code_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Shares at the ends, the tallest pile near the top, empty codes, combs."""
    values = _looked_at(sample.capture, sample.as_taken)
    if not values.size:
        return
    white = sample.capture.context.white_level_dn
    histogram = np.bincount(values.astype(np.uint16))
    top = len(histogram) - 1
    ends = np.array([histogram[int(np.ceil(white)) :].sum(), histogram[0]]) / values.size
    yield StatisticBlock("clipped", "pixel", ends, [{"end": "white"}, {"end": "zero"}], 0.003)
    if sample.capture.kind != "dark" and not sample.capture.own_edges:
        yield StatisticBlock(
            "top_level",
            "pixel",
            np.array([top / white, _pile(histogram)]),
            [{"what": "largest value"}, {"what": "share at the largest values"}],
            np.array([0.01, 0.004]),
        )
    if white < _DEEPEST_DN:
        comb = _comb(histogram)
        yield StatisticBlock(
            "code_comb",
            "readout",
            comb,
            [*({"period_dn": p} for p in PERIODS), {"what": "empty codes"}],
            0.02,
        )


def _looked_at(capture: RealCapture, frames: NDArray[np.float32]) -> NDArray[np.float32]:
    """(M,) `sampled` values of the pixels that count; which those are is worked out once."""
    if capture.valid.all():
        return sampled(frames, CODE_SAMPLES)
    known = _PLACES.setdefault(capture, {})
    if frames.shape not in known:
        places = np.arange(frames.size).reshape(frames.shape)
        known[frames.shape] = sampled(places[:, capture.valid], CODE_SAMPLES)
    return np.take(frames, known[frames.shape])


def _pile(histogram: NDArray[np.int64]) -> float:
    """Share of pixels within two codes of the largest value."""
    return float(histogram[-3:].sum() / histogram.sum())


def _comb(histogram: NDArray[np.int64]) -> NDArray[np.float64]:
    """Strength of each period in the used codes, and the share of codes within their range that are empty."""
    total = histogram.sum()
    used = np.flatnonzero(np.cumsum(histogram) > 0.02 * total)
    low = int(used[0])
    high = int(np.searchsorted(np.cumsum(histogram), 0.98 * total))
    inside = histogram[low : high + 1].astype(np.float64)
    strengths = np.zeros(len(PERIODS))
    if len(inside) >= max(PERIODS) and inside.any():
        codes = np.arange(len(inside))
        waves = np.exp(2j * np.pi * np.outer(1 / np.array(PERIODS), codes))
        strengths = np.abs(waves @ inside) / inside.sum()
    empty = float(np.mean(inside == 0)) if inside.sum() > 20 * len(inside) else 0.0  # even of a quiet wall
    return np.array([*strengths, empty])
