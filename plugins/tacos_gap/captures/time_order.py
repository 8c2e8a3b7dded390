"""Captures in the order they were taken, and what their times make doubtful."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from tacos_gap.captures.capture import RealCapture

CLOCK_S = 1.0
"""Times may be off by so much: many cameras note whole seconds."""

FEWEST = 3
"""Captures that tell a drift from two that differ."""

LEAST_DRIFT = 0.01
"""Relative change of light below which no drift is suspected."""

_ALIKE = 0.1
"""Relative difference of expected signals within which captures are alike: a curved response then bends their
ratios by little."""

_DIM_DN = 8.0
"""Signal below which ratios say nothing [DN]."""


def in_time_order(captures: Sequence[RealCapture]) -> tuple[RealCapture, ...]:
    """Captures by `taken_s`; those without one stay behind the capture they are listed after."""
    moments = []
    latest = -math.inf
    for capture in captures:
        latest = latest if capture.taken_s is None else capture.taken_s
        moments.append(latest)
    order = sorted(range(len(captures)), key=moments.__getitem__)
    return tuple(captures[place] for place in order)


def time_doubts(captures: Sequence[RealCapture]) -> Iterator[str]:
    """Sentences on what contradicts or follows from `taken_s`, each beginning with what it is about."""
    timed = [(capture, capture.taken_s) for capture in captures if capture.taken_s is not None]
    for (before, earlier_s), (after, later_s) in pairwise(timed):
        if later_s < earlier_s:
            yield (
                f"{after.id}: it is listed after {before.id} and was taken {earlier_s - later_s:g} s before "
                f"it (taken_s); captures are read in the order of their times."
            )
    by_time = sorted(timed, key=lambda each: each[1])
    for (before, earlier_s), (after, later_s) in pairwise(by_time):
        shortest_s = min(_least_duration_s(before), _least_duration_s(after))
        if later_s - earlier_s + CLOCK_S < shortest_s:
            yield (
                f"{after.id}: it was taken {later_s - earlier_s:g} s after {before.id} (taken_s), while the "
                f"frames of either take {shortest_s:.3g} s; check taken_s and exposure_ms."
            )
    yield from _drifts([capture for capture, _ in by_time])


def _least_duration_s(capture: RealCapture) -> float:
    """Least duration of its frames; 0 where no exposure time is stated [s]."""
    if not capture.exposure_stated:
        return 0.0
    exposure_s = capture.context.exposure_s
    step_s = max(capture.context.frame_interval_s or 0.0, exposure_s)
    return (capture.frames - 1) * step_s + exposure_s


def _drifts(captures: Sequence[RealCapture]) -> Iterator[str]:
    """Light that only rises or only falls, over captures in time order that should be equally bright."""
    series: list[list[tuple[RealCapture, float, float]]] = []
    for capture in captures:
        if (signals := _signals_dn(capture)) is None:
            continue
        real, expected = signals
        home = next((members for members in series if _alike(members[0], capture, expected)), None)
        if home is None:
            series.append([(capture, expected, real / expected)])
        else:
            home.append((capture, expected, real / expected))
    for members in series:
        first, last = members[0], members[-1]
        steps = np.diff([ratio for _, _, ratio in members])
        change = last[2] / first[2] - 1
        margin = max(LEAST_DRIFT, *(capture.level_uncertainty for capture, _, _ in members))
        if len(members) < FEWEST or abs(change) <= margin or not ((steps > 0).all() or (steps < 0).all()):
            continue
        span_s = (last[0].taken_s or 0.0) - (first[0].taken_s or 0.0)
        yield (
            f"{last[0].id}: against what is expected it is {abs(change):.1%} "
            f"{'brighter' if change > 0 else 'darker'} than {first[0].id}, {span_s:g} s before it, and the "
            f"{len(members)} captures like them change in order of time: a lamp that warms up, daylight, or "
            f"automatic exposure. Let the lamp settle, or state the change as level_uncertainty."
        )


def _signals_dn(capture: RealCapture) -> tuple[float, float] | None:
    """Mean signal above the pedestal, real and expected; None where they cannot be compared [DN]."""
    if capture.expected_dn is None or capture.kind == "dark" or not capture.valid.any():
        return None
    black, white = capture.context.black_level_dn, capture.context.white_level_dn
    real = float(capture.real_dn[:, capture.valid].mean(dtype=np.float64)) - black
    expected = float(capture.expected_dn[:, capture.valid].mean(dtype=np.float64)) - black
    clipped = (capture.real_dn[:, capture.valid] >= white).mean() > LEAST_DRIFT
    return None if clipped or min(real, expected) < _DIM_DN else (real, expected)


def _alike(member: tuple[RealCapture, float, float], capture: RealCapture, expected_dn: float) -> bool:
    """True if a capture should be as bright as a member of a series, and is of the same kind."""
    other, level_dn, _ = member
    return (
        (other.kind, other.context.gain_db, other.context.exposure_s)
        == (capture.kind, capture.context.gain_db, capture.context.exposure_s)
        and other.geometry == capture.geometry
        and abs(expected_dn / level_dn - 1) < _ALIKE
    )
