"""Bad rows and columns as captures of even fields show them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
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
_ROUNDED_DN = ROUNDING_DN / 3**0.5  # standard deviation of what rounding to whole numbers does
_DEAD = 0.9
"""Share of the signal that a dead line lacks."""

_FEW = 0.1
"""Share of lines above which a pattern of all lines is meant, not single bad ones."""


def bad_lines(captures: Captures) -> Iterator[Mapping[str, Any]]:
    """Settings of line defects that even fields suggest: shares and offset of bad columns, bad rows, or both.

    Lines that are dead stand off by the light of each capture. What others stand off by is the same in all
    captures, and seen best in their mean.
    """
    fields = [
        (capture, _residual(capture))
        for capture in of_kind(captures, "dark", "flat", "bracket")
        if capture.expected_dn is not None and min(capture.valid.shape) >= NEIGHBOURS
    ]
    found: dict[str, Mapping[str, Any]] = {}
    for key, turned in (("column_share", True), ("row_share", False)):
        lines = [plane.T if turned else plane for _, plane in fields]
        in_each = [_few(_offsets(_pieces(each))) for each in lines]
        if any(_is_dead(capture, at[at != 0]) for (capture, _), at in zip(fields, in_each, strict=True)):
            found[key] = {key: _largest_share(in_each), "dead": True}
            continue
        in_mean = [_few(_offsets(_mean(alike))) for alike in _of_one_shape(map(_pieces, lines))]
        if share := _largest_share([*in_mean, *in_each]):
            seen = in_mean if any(map(np.any, in_mean)) else in_each
            found[key] = {
                key: share,
                "offset_dn": float(np.median(np.concatenate([at[at != 0] for at in seen]))),
            }
    if len(found) == 2 and len({"dead" in settings for settings in found.values()}) == 1:
        columns, rows = found.values()
        yield {**columns, **rows, **_offset_of_both(columns, rows)}
    yield from found.values()


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


def _of_one_shape(pieces: Iterable[NDArray[np.float64]]) -> Iterable[list[NDArray[np.float64]]]:
    """Arrays by their shape: captures may differ in their crop."""
    alike: dict[tuple[int, ...], list[NDArray[np.float64]]] = {}
    for each in pieces:
        alike.setdefault(each.shape, []).append(each)
    return alike.values()


def _mean(pieces: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Their mean, each weighed by how little it scatters; by no more than rounding lets tell."""
    spreads = np.array([middle_and_spread(each)[1] for each in pieces])
    return np.average(pieces, axis=0, weights=1 / np.maximum(spreads, _ROUNDED_DN) ** 2)


def _offset_of_both(columns: Mapping[str, Any], rows: Mapping[str, Any]) -> dict[str, float]:
    """One offset for columns and rows, which have the same on one sensor; none of dead lines."""
    if "dead" in columns:
        return {}
    return {"offset_dn": (columns["offset_dn"] + rows["offset_dn"]) / 2}


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
    """Whether lines lack all of the signal of a lit capture."""
    assert capture.expected_dn is not None
    if not offsets.size:
        return False
    signal = float(capture.expected_dn.mean()) - capture.context.black_level_dn
    return capture.kind != "dark" and signal > 0 and bool(np.median(offsets) < -_DEAD * signal)
