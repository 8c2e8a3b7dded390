"""The lattice of a chessboard's corners: a part of it grown to all that a picture shows, and no further.

OpenCV finds a part of a board where a lens bends the rest, and rows of false corners where a board's margin
meets something dark. The four squares around a corner tell: opposite ones are alike.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from itertools import islice

import cv2
import numpy as np
from numpy.typing import NDArray

Place = tuple[int, int]
"""Column and row of a corner."""

Corner = NDArray[np.float64]
"""(2,) where it is seen [px]."""

_TRIED = 3
"""Squares that the lattice is grown from."""

_INTO_SQUARE = 0.35
"""Way from a corner into the squares around it, over the distance of corners: clear of blurred borders."""

_CROSSED = 0.7
"""Difference of the two pairs of opposite squares, over the range of the four: 1 at a corner, .5 at the
margin of a board, where three of them are paper."""

_LEAST_CONTRAST = 0.25
"""Range of the four, over the usual one of the board."""

_SEARCH = 0.25
"""Distance from where a corner is foreseen, over that of corners, in which it is looked for."""

_MOST_OF_A_LINE = 0.5
"""Share of the corners of the fullest line that make an outermost one a line."""


def size_of_board(grey: NDArray[np.uint8], corners_px: NDArray[np.floating]) -> Place | None:
    """Columns and rows of inner corners that a picture shows, the larger first; None where no board is.

    - `corners_px`: (R, C, 2) corners of a part of the board, among which lines may be false or missing [px].
    """
    image = cv2.GaussianBlur(grey, (0, 0), 1.0).astype(np.float32)
    grown = (_grown(grey, image, square) for square in _squares(image, corners_px))
    lattice = max(islice(grown, _TRIED), key=len, default={})
    if not lattice:
        return None
    extents = [_extent([place[axis] for place in lattice]) for axis in (0, 1)]
    return max(extents), min(extents)


def _squares(image: NDArray[np.float32], corners_px: NDArray[np.floating]) -> Iterator[dict[Place, Corner]]:
    """Corners of single squares, even inside, between corners of a board; those in its middle first."""
    rows, columns = corners_px.shape[:2]
    middle = (rows - 2) / 2, (columns - 2) / 2
    for r, c in sorted(
        np.ndindex(rows - 1, columns - 1), key=lambda at: abs(at[0] - middle[0]) + abs(at[1] - middle[1])
    ):
        square = {(x, y): np.asarray(corners_px[r + y, c + x], np.float64) for x in (0, 1) for y in (0, 1)}
        a, b, d = (square[place] for place in ((0, 0), (1, 0), (0, 1)))
        shares = np.array([0.25, 0.5, 0.75])
        inside = a + shares[:, None, None] * (b - a) + shares[:, None] * (d - a)
        spread = [float(np.ptp(_around(image, square, place))) for place in square]
        if np.ptp(_values(image, inside.reshape(-1, 2))) < _LEAST_CONTRAST * min(spread) and all(
            _is_crossed(image, square, place, min(spread)) for place in square
        ):
            yield square


def _grown(
    grey: NDArray[np.uint8], image: NDArray[np.float32], square: dict[Place, Corner]
) -> dict[Place, Corner]:
    """A lattice with all corners that continue it."""
    lattice = dict(square)
    usual = float(np.median([np.ptp(_around(image, square, place)) for place in square]))
    while found := {
        place: at
        for place, at in _foreseen(grey, lattice)
        if _is_crossed(image, {**lattice, place: at}, place, usual)
    }:
        lattice |= found
    return lattice


def is_whole(grey: NDArray[np.uint8], corners_px: NDArray[np.floating]) -> bool:
    """True if the outermost lines of (R, C, 2) corners are lines of a board as well [px]."""
    image = cv2.GaussianBlur(grey, (0, 0), 1.0).astype(np.float32)
    found = {
        place[::-1]: np.asarray(corners_px[place], np.float64) for place in np.ndindex(*corners_px.shape[:2])
    }
    usual = float(np.median([np.ptp(_around(image, found, place)) for place in found]))
    crossed = [place for place in found if _is_crossed(image, found, place, usual)]
    return tuple(_extent([place[axis] for place in crossed]) for axis in (0, 1)) == corners_px.shape[1::-1]


def _extent(lines: list[int]) -> int:
    """Lines from the first to the last of those with enough corners."""
    counts = Counter(lines)
    full = [line for line, count in counts.items() if count >= _MOST_OF_A_LINE * max(counts.values())]
    return max(full) - min(full) + 1 if full else 0


def _foreseen(grey: NDArray[np.uint8], lattice: Mapping[Place, Corner]) -> Iterator[tuple[Place, Corner]]:
    """Corners beside known ones, by the two or three before them in their line, and where they are seen."""
    tried: set[Place] = set()
    for (c, r), at in lattice.items():
        for dc, dr in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            new = c + dc, r + dr
            before, further = lattice.get((c - dc, r - dr)), lattice.get((c - 2 * dc, r - 2 * dr))
            if new in lattice or new in tried or before is None:
                continue
            foreseen = 2 * at - before if further is None else 3 * at - 3 * before + further
            if (seen := _seen_near(grey, foreseen, float(np.linalg.norm(at - before)))) is not None:
                tried.add(new)
                yield new, seen


def _seen_near(
    grey: NDArray[np.uint8], foreseen: NDArray[np.float64], distance_px: float
) -> NDArray[np.float64] | None:
    reach = max(2, round(_SEARCH * distance_px))
    if distance_px < 4 or (foreseen < reach).any() or (foreseen >= np.array(grey.shape[::-1]) - reach).any():
        return None
    start = foreseen.astype(np.float32).reshape(1, 1, 2)
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 20, 0.02)
    seen = np.asarray(cv2.cornerSubPix(grey, start, (reach, reach), (-1, -1), stop), np.float64).ravel()
    return seen if np.linalg.norm(seen - foreseen) <= _SEARCH * distance_px else None


def _is_crossed(
    image: NDArray[np.float32], lattice: Mapping[Place, Corner], place: Place, usual: float
) -> bool:
    """True if the squares around a corner are those of a chessboard, in the sense of the others."""
    around = _around(image, lattice, place)
    spread = float(np.ptp(around))
    crossed = abs(around[0] + around[2] - around[1] - around[3]) / 2
    return spread > _LEAST_CONTRAST * usual and crossed > _CROSSED * spread


def _around(image: NDArray[np.float32], lattice: Mapping[Place, Corner], place: Place) -> NDArray[np.float64]:
    """(4,) values of the squares around a corner, in turn; all alike where it has no neighbours."""
    along, down = (_step(lattice, place, axis) for axis in (0, 1))
    if along is None or down is None:
        return np.zeros(4)
    signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    return _values(image, lattice[place] + _INTO_SQUARE * (signs[:, :1] * along + signs[:, 1:] * down))


def _values(image: NDArray[np.float32], at_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """(K,) values at the pixels nearest to (K, 2) places, of those outside at the border."""
    x, y = np.clip(np.rint(at_px), 0, np.array(image.shape[::-1]) - 1).astype(int).T
    return np.asarray(image[y, x], np.float64)


def _step(lattice: Mapping[Place, Corner], place: Place, axis: int) -> NDArray[np.float64] | None:
    """From a corner to the next along an axis, by its neighbours or those of the line beside it [px]."""
    sideways = (0, 1) if axis == 0 else (1, 0)
    for line in (0, 1, -1):
        beside = place[0] + line * sideways[0], place[1] + line * sideways[1]
        near = [(beside[0] + k * (axis == 0), beside[1] + k * (axis == 1)) for k in (-1, 0, 1)]
        there = [k for k, at in enumerate(near) if at in lattice]
        if beside in lattice and len(there) > 1:
            return (lattice[near[there[-1]]] - lattice[near[there[0]]]) / (there[-1] - there[0])
    return None
