"""Bad rows and columns as captures of even fields show them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from tacos_framework import Captures, ObservedCapture, of_kind
from tacos_plugins.effects.darks import ROUNDING_DN, middle_and_spread

NEIGHBOURS = 9
"""Lines whose median one of them is held against."""

_SPREADS = 8.0
_WHOLE = 0.9
"""Share of a line's length over which it must be bad."""

_PIECES = 8
_ROUNDED_DN = ROUNDING_DN / 3**0.5  # standard deviation of what rounding to whole numbers does
_DEAD = 0.9
"""Share of the signal that a dead line lacks."""

_FEW = 0.1
"""Share of lines above which a pattern of all lines is meant, not single bad ones."""


@dataclass(frozen=True)
class _BadLines:
    share: float
    offset_dn: float | None
    """Offset above the others; None where they are dead [DN]."""


def bad_lines(captures: Captures) -> Iterator[Mapping[str, Any]]:
    """Settings of line defects that even fields suggest: of bad columns and rows together, and of either."""
    fields = [
        (capture, _residual(capture))
        for capture in of_kind(captures, "dark", "flat", "bracket")
        if capture.expected_dn is not None and min(capture.valid.shape) >= NEIGHBOURS
    ]
    columns, rows = _found([(capture, plane.T) for capture, plane in fields]), _found(fields)
    if columns and rows and (columns.offset_dn is None) == (rows.offset_dn is None):
        yield {"column_share": columns.share, "row_share": rows.share, **_shown_by(columns, rows)}
    if columns:
        yield {"column_share": columns.share, **_shown_by(columns)}
    if rows:
        yield {"row_share": rows.share, **_shown_by(rows)}


def _shown_by(*bad: _BadLines) -> dict[str, Any]:
    """Settings of the bad lines that are seen; one offset for all, as they are of one sensor."""
    offsets_dn = [each.offset_dn for each in bad if each.offset_dn is not None]
    return {"offset_dn": float(np.mean(offsets_dn))} if offsets_dn else {"dead": True}


def _found(fields: Sequence[tuple[ObservedCapture, NDArray[np.floating]]]) -> _BadLines | None:
    """The bad lines of captures and their (N, L) residuals, line by line; None where there are none.

    Dead lines stand off by the light of each capture. What others stand off by is the same in all, and seen
    best in their mean.
    """
    pieces = [_pieces(lines) for _, lines in fields]
    in_each = [_few(_offsets(each)) for each in pieces]
    if any(_is_dead(capture, at[at != 0]) for (capture, _), at in zip(fields, in_each, strict=True)):
        return _BadLines(_largest_share(in_each), None)
    captures = [capture for capture, _ in fields]
    in_mean = [_few(_offsets(_mean(alike))) for alike in _of_the_same_lines(captures, pieces)]
    if not (share := _largest_share([*in_mean, *in_each])):
        return None
    seen = np.concatenate(in_mean if any(map(np.any, in_mean)) else in_each)
    return _BadLines(share, float(np.median(seen[seen != 0])))


def _residual(capture: ObservedCapture) -> NDArray[np.floating]:
    """(H, W) what the frames show above what is expected, 0 where that says nothing [DN]."""
    assert capture.expected_dn is not None
    plane = (capture.real_dn.mean(axis=0) - capture.expected_dn.mean(axis=0)).mean(axis=-1)
    return np.where(capture.valid, plane, 0)


def _few(offsets: NDArray[np.float64]) -> NDArray[np.float64]:
    """Offsets of lines, 0 for all where a pattern of all lines is meant."""
    return offsets if np.mean(offsets != 0) <= _FEW else np.zeros_like(offsets)


def _largest_share(found_in: Sequence[NDArray[np.float64]]) -> float:
    """Share of the lines that are bad where most are; 0 where none are."""
    return max((int(np.count_nonzero(offsets)) / offsets.size for offsets in found_in), default=0.0)


def _of_the_same_lines(
    captures: Sequence[ObservedCapture], pieces: Sequence[NDArray[np.float64]]
) -> Iterable[list[NDArray[np.float64]]]:
    """Pieces by the lines of the sensor that they are of: captures may differ in their crop."""
    alike: dict[Any, list[NDArray[np.float64]]] = {}
    for capture, each in zip(captures, pieces, strict=True):
        alike.setdefault((capture.geometry.offset_px, each.shape), []).append(each)
    return alike.values()


def _mean(pieces: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Their mean, each weighed by how little it scatters; by no more than rounding lets tell."""
    spreads = np.array([middle_and_spread(each)[1] for each in pieces])
    return np.average(pieces, axis=0, weights=1 / np.maximum(spreads, _ROUNDED_DN) ** 2)


def _pieces(lines: NDArray[np.floating]) -> NDArray[np.float64]:
    """(P, N) what pieces of (N, L) lines stand above their neighbours [DN]."""
    # of each piece the middle pixel, so that bright pixels that stand alone make no line
    pieces = np.stack([np.median(piece, axis=1) for piece in np.array_split(lines, _PIECES, axis=1)])
    return np.asarray(pieces - median_filter(pieces, (1, NEIGHBOURS), mode="nearest"), np.float64)


def _offsets(pieces: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N,) offsets of lines that are bad over their whole length, 0 of the others [DN]."""
    offset = pieces.mean(axis=0)
    _, spread = middle_and_spread(offset)
    stands_out = np.abs(offset) > ROUNDING_DN / 2 + _SPREADS * spread
    along = np.mean(np.sign(offset) * pieces > np.abs(offset) / 2, axis=0) >= _WHOLE
    return np.where(stands_out & along, offset, 0.0).astype(np.float64)


def _is_dead(capture: ObservedCapture, offsets: NDArray[np.float64]) -> bool:
    """True if lines lack all of the signal of a lit capture."""
    assert capture.expected_dn is not None
    if not offsets.size:
        return False
    signal = float(capture.expected_dn.mean()) - capture.context.black_level_dn
    return capture.kind != "dark" and signal > 0 and bool(np.median(offsets) < -_DEAD * signal)
