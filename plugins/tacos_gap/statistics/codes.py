"""The values themselves: clipping, piled-up and missing codes."""

from __future__ import annotations

from collections.abc import Iterator
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture
from tacos_gap.statistics.block import Sample, StatisticBlock, expected_signal
from tacos_gap.statistics.sampled import CODE_SAMPLES, sampled

PERIODS = (2, 3, 4, 5, 6, 8)
"""Steps between used codes that are looked for [DN]."""

_DEEPEST_DN = 4096
"""Files deeper than this have codes to spare; combs are not looked for."""

_LEAST_WIDTH_DN = 2.0
"""Standard deviation of the values expected, from which on their largest ones are few and a pile of them is a
level at which the camera stops: of a narrower wall these hold a percent to all of it, as its level falls
between two codes."""

_COMMON = (0.02, 0.98)
"""Quantiles between which values are looked at for combs, so that hot pixels do not count."""

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
    if not sample.capture.own_edges and _is_wide(sample.capture):
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


def _is_wide(capture: RealCapture) -> bool:
    """True if the values of a picture spread over several codes, by what is expected of it."""
    if capture.kind == "dark":
        return False
    signal = expected_signal(capture)[capture.valid]
    if not signal.size:
        return False
    noise_dn2 = np.max(capture.noise.photon_dn) * max(float(signal.mean()), 0.0)
    noise_dn2 += np.max(capture.noise.thermal_dn2)
    return bool(float(signal.var()) + noise_dn2 > _LEAST_WIDTH_DN**2)


def _pile(histogram: NDArray[np.int64]) -> float:
    """Share of pixels within two codes of the largest value."""
    return float(histogram[-3:].sum() / histogram.sum())


def _comb(histogram: NDArray[np.int64]) -> NDArray[np.float64]:
    """Strength of each period in the common codes, and the share of steps between them that lead to none.

    Codes at the quantiles count in part, so that strengths change smoothly with level and noise.
    """
    reached = np.cumsum(histogram) / histogram.sum()
    share = np.diff(np.clip(reached, *_COMMON), prepend=_COMMON[0])
    used = np.flatnonzero(share)
    share = share[used[0] : used[-1] + 1] / share.sum()
    waves = np.exp(2j * np.pi * np.outer(1 / np.array(PERIODS), np.arange(len(share))))
    steps = len(share) - 1
    seen = histogram[used[0] : used[-1] + 1]
    is_seen_well = steps > 0 and seen.sum() > 20 * len(seen)  # even of a quiet wall
    return np.array([*np.abs(waves @ share), np.count_nonzero(seen == 0) / steps if is_seen_well else 0.0])
