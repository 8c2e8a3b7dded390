"""Bad rows and columns as captures of even fields show them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from tacos_framework.contracts.observed import Captures, ObservedCapture, of_kind
from tacos_plugins.effects.darks import ROUNDING_DN, middle_and_spread

NEIGHBOURS = 9
"""Lines whose median one of them is held against."""

_SPREADS = 8.0
_WHOLE = 0.9
"""Share of a line's length over which it must be bad."""

_PIECES = 8
_DEAD = 0.9
"""Share of the signal that a dead line lacks."""

_FEW = 0.1
"""Share of lines above which a pattern of all lines is meant, not single bad ones."""


def bad_lines(captures: Captures) -> Iterator[Mapping[str, Any]]:
    """Settings of line defects that even fields suggest: shares and offset of bad columns, of bad rows."""
    offsets: dict[str, list[NDArray[np.float64]]] = {"column_share": [], "row_share": []}
    dead: dict[str, bool] = {}
    for capture in of_kind(captures, "dark", "flat", "bracket"):
        if capture.expected_dn is None or min(capture.valid.shape) < NEIGHBOURS:
            continue
        plane = (capture.real_dn.mean(axis=0) - capture.expected_dn.mean(axis=0)).mean(axis=-1)
        plane = np.where(capture.valid, plane, 0)
        for key, lines in (("column_share", plane.T), ("row_share", plane)):
            found = _offsets(lines)
            if found.any() and np.mean(found != 0) <= _FEW:
                offsets[key].append(found)
                dead[key] = dead.get(key, False) or _is_dead(capture, found[found != 0])
    for key, found_in in offsets.items():
        if found_in:
            largest = max(found_in, key=lambda found: np.count_nonzero(found))
            share = int(np.count_nonzero(largest)) / largest.size
            offset_dn = float(np.median(largest[largest != 0]))
            yield {key: share, "dead": True} if dead[key] else {key: share, "offset_dn": offset_dn}


def _offsets(lines: NDArray[np.floating]) -> NDArray[np.float64]:
    """(N,) offsets of (N, L) lines that are bad over their whole length, 0 of the others [DN]."""
    # of each piece the middle pixel, so that bright pixels that stand alone make no line
    pieces = np.stack([np.median(piece, axis=1) for piece in np.array_split(lines, _PIECES, axis=1)])
    pieces = pieces - median_filter(pieces, (1, NEIGHBOURS), mode="nearest")
    offset = pieces.mean(axis=0)
    _, spread = middle_and_spread(offset)
    stands_out = np.abs(offset) > ROUNDING_DN / 2 + _SPREADS * spread
    along = np.mean(np.sign(offset) * pieces > np.abs(offset) / 2, axis=0) >= _WHOLE
    return np.where(stands_out & along, offset, 0.0).astype(np.float64)


def _is_dead(capture: ObservedCapture, offsets: NDArray[np.float64]) -> bool:
    """Whether lines lack all of the signal of a lit capture."""
    assert capture.expected_dn is not None
    signal = float(capture.expected_dn.mean()) - capture.context.black_level_dn
    return capture.kind != "dark" and signal > 0 and bool(np.median(offsets) < -_DEAD * signal)
