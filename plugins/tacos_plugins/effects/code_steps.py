"""Distance between the codes that files use, where a converter or a table left others empty."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tacos_framework import SURE, Captures
from tacos_plugins.effects.closed_forms import Measured

_DEEPEST_DN = 4095
"""Files deeper than this have codes to spare: most are unused anyway."""

_FEWEST_CODES = 12
"""Used codes from which on their distance is known."""

_LEAST_GAP_DN = 2.0

_IN_STEP = 0.6
"""Coherence of the used codes with a step from which on it is theirs. Rounding to whole codes leaves .9 of it
at 4.05 DN and .66 at 2.12 DN; codes that a tone curve spreads stay below .5."""

_AS_HIGH = 0.9
"""Share of the highest peak from which on a peak is as good: a few walls far apart leave several."""

_ROUNDING_DN = 12**-0.5
"""Standard deviation of what rounding does to the first and the last code."""

_SAMPLES = 400_000
"""Values of a capture that are looked at."""


def code_step_dn(captures: Captures) -> Measured | None:
    """Step between used codes in all captures together; None where nearly all codes are used [DN].

    Codes have the same phase on a step of the right length, and so their mean phasor is long: the peak of a
    periodogram near their median distance. Bits that are shifted up leave whole steps: one that may be whole
    is, and as an `int` it is a guess that no fit moves.
    """
    codes = _used_codes(captures)
    if len(codes) < _FEWEST_CODES:
        return None
    gap = float(np.median(np.diff(codes)))
    if gap < _LEAST_GAP_DN:
        return None
    span = float(np.ptp(codes))
    nyquist = 0.5 + 0.05 / span  # codes are whole numbers
    frequencies = np.arange(1 / (gap + 1), min(1 / (gap - 1), nyquist), 0.05 / span)
    coherence = np.abs(np.exp(2j * np.pi * np.outer(frequencies, codes)).mean(axis=1))
    if coherence.max() < _IN_STEP:
        return None
    inner = coherence[1:-1]
    peaks = (inner >= coherence[:-2]) & (inner >= coherence[2:]) & (inner > _AS_HIGH * coherence.max())
    steps_dn = 1 / frequencies[1:-1][peaks]
    step_dn = float(steps_dn[np.argmin(np.abs(steps_dn - gap))]) if peaks.any() else gap
    error_dn = _ROUNDING_DN * step_dn / span
    is_whole = abs(step_dn - round(step_dn)) < SURE * error_dn
    return Measured(round(step_dn) if is_whole else step_dn, error_dn)


def _used_codes(captures: Captures) -> NDArray[np.int64]:
    """Codes that any pixel has, but for the least and the greatest, at which values are cut off."""
    counts = np.zeros(_DEEPEST_DN + 1, np.int64)
    for codes in _codes(captures):
        counts += np.bincount(codes, minlength=len(counts))
    return np.flatnonzero(counts)[1:-1]


def _codes(captures: Captures) -> Iterator[NDArray[np.int64]]:
    """Values of the first frame of each capture, all of its channels; none of means, which are not whole."""
    for capture in captures:
        values = capture.real_dn[0].reshape(-1)
        some = values[:: max(1, values.size // _SAMPLES)]
        if capture.context.white_level_dn <= _DEEPEST_DN and np.array_equal(some, np.rint(some)):
            yield np.clip(some, 0, _DEEPEST_DN).astype(np.int64)
