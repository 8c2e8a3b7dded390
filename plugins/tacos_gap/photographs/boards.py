"""The boards of a set of photographs: their size, by the fullest that several of them show."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tacos_files.camera_images import read_image
from tacos_gap.photographs.board_lattice import is_whole
from tacos_gap.photographs.charuco import Layout, Markers, find_markers, layout_of
from tacos_gap.photographs.picture import Picture

USUAL_SQUARE_MM = 25.0
_CANDIDATES = 3
_FEWEST = 0.15
"""Share of the pictures of boards that show one whole from which on it is the board."""

_ENOUGH_VIEWS = 3
"""Views that say what board it is, so that it is looked for in scenes as well."""

_USUAL = ((7, 5), (7, 6), (8, 5), (8, 6), (9, 6), (9, 7), (10, 7), (11, 7), (11, 8), (12, 8))
"""Boards that are printed often, of which a part may have been counted."""

_SEARCHED = 4
"""Pictures that a usual board is looked for in before all of them are."""

_FEWEST_CORNERS = 8
_WORKING_PX = 1280
_PROBED = 2


@dataclass(frozen=True, eq=False)
class BoardView:
    """Corners of a board in a picture."""

    points: NDArray[np.float32]  # (K, 3) where they are on the board [squares]
    corners_px: NDArray[np.float32]  # (K, 2) where they are seen [px]


@dataclass(frozen=True, eq=False)
class BoardFound:
    """A board in several pictures."""

    inner_corners: tuple[int, int]  # along its rows and columns
    views: Mapping[Picture, BoardView]
    layout: Layout | None = None  # of a ChArUco; None for a chessboard

    def entry(self, square_mm: float) -> dict[str, Any]:
        entry: dict[str, Any] = {"inner_corners": list(self.inner_corners), "square_mm": square_mm}
        if self.layout is None:
            return entry
        marker_mm = round(self.layout.marker_share * square_mm, 4)
        return {"pattern": "charuco", **entry, "marker_mm": marker_mm, "dictionary": self.layout.dictionary}


def boards_of(pictures: Sequence[Picture], given: tuple[int, int] | None) -> tuple[BoardFound, ...]:
    markers = {picture: picture.shown.markers for picture in pictures if picture.shown.markers is not None}
    plain = [picture for picture in pictures if picture not in markers]
    for picture in plain[:_PROBED]:  # corners of a ChArUco may be counted as those of a chessboard
        if (seen := find_markers(_grey(picture)[0])) is not None:
            family = seen.family
            markers |= {p: m for p in plain if (m := find_markers(_grey(p)[0], family)) is not None}
            break
    found = (_charuco(markers), _chessboard([p for p in plain if p not in markers], given))
    return tuple(board for board in found if board is not None and board.views)


def _charuco(markers: Mapping[Picture, Markers]) -> BoardFound | None:
    layout = layout_of(list(markers.values())) if markers else None
    if layout is None:
        return None
    board = layout.board()
    detector = cv2.aruco.CharucoDetector(board)
    points = np.asarray(board.getChessboardCorners(), np.float32)
    views = {}
    for picture in markers:
        grey, scale = _grey(picture)
        corners, ids, _, _ = detector.detectBoard(grey)
        if ids is not None and len(ids) >= _FEWEST_CORNERS:
            views[picture] = BoardView(points[np.ravel(ids)], _unscaled(corners, scale))
    return BoardFound((layout.squares[0] - 1, layout.squares[1] - 1), views, layout)


def _chessboard(pictures: Sequence[Picture], given: tuple[int, int] | None) -> BoardFound | None:
    if not pictures:
        return None
    greys = {picture: _grey(picture) for picture in pictures}
    sizes = [given] if given else sorted(_sizes(pictures, greys), key=lambda size: -size[0] * size[1])
    found = BoardFound(sizes[0], {}) if sizes else None
    for size in sizes:  # a part is found wherever all is, so that the fullest comes first
        board = _views_of(size, greys)
        if len(board.views) >= max(_FEWEST * len(pictures), min(2, len(pictures))):
            return board
        found = max(found or board, board, key=lambda each: len(each.views))
    return found


def _sizes(
    pictures: Sequence[Picture], greys: Mapping[Picture, tuple[NDArray[np.uint8], float]]
) -> Iterator[tuple[int, int]]:
    """Sizes that a chessboard may have: the fullest and the most frequent counts, and larger usual ones.

    The count of one picture may be of a part, where a border, shine or the lens hides the rest.
    """
    counted = [picture.shown.corners for picture in pictures if picture.shown.corners]
    fullest = sorted(set(counted), key=lambda size: -size[0] * size[1])[:_CANDIDATES]
    frequent = sorted(set(counted), key=lambda size: -counted.count(size))[:_CANDIDATES]
    yield from dict.fromkeys([*frequent, *fullest])
    counts = np.array(counted)
    least = counts.max(axis=0) if len(counts) else np.zeros(2)
    step = max(1, len(pictures) // _SEARCHED)
    some = [greys[picture][0] for picture in pictures[::step]]
    for size in _USUAL:
        larger = size not in counted and bool((np.array(size) >= least).all())
        if larger and any(_at_a_glance(grey, size) is not None for grey in some):
            yield size


def _views_of(size: tuple[int, int], greys: Mapping[Picture, tuple[NDArray[np.uint8], float]]) -> BoardFound:
    columns, rows = size
    points = np.zeros((columns * rows, 3), np.float32)
    points[:, :2] = np.mgrid[:columns, :rows].T.reshape(-1, 2)
    views = {
        picture: BoardView(points, _unscaled(corners, scale))
        for picture, (grey, scale) in greys.items()
        if (corners := _corners(grey, size)) is not None and is_whole(grey, corners.reshape(rows, columns, 2))
    }
    return BoardFound(size, views)


def with_unseen_views(
    pictures: Sequence[Picture], boards: Sequence[BoardFound]
) -> tuple[list[Picture], tuple[BoardFound, ...]]:
    """Pictures and boards, with the views of a known chessboard that were taken for scenes."""
    known = next((b for b in boards if b.layout is None and len(b.views) >= _ENOUGH_VIEWS), None)
    scenes = [picture for picture in pictures if picture.shown.kind == "scene"]
    if known is None or not scenes:
        return list(pictures), tuple(boards)
    seen = _views_of(known.inner_corners, {picture: _grey(picture) for picture in scenes}).views
    as_boards = {p: replace(p, shown=replace(p.shown, kind="board", doubt="")) for p in seen}
    more = {as_boards[picture]: view for picture, view in seen.items()}
    found = replace(known, views={**known.views, **more})
    return [as_boards.get(p, p) for p in pictures], tuple(found if b is known else b for b in boards)


def _grey(picture: Picture) -> tuple[NDArray[np.uint8], float]:
    """A picture in grey, its range stretched to eight bits, no longer than `_WORKING_PX`; and its scale."""
    image = np.asarray(read_image(picture.path, str(picture.path)), np.float32).mean(axis=-1)
    scale = min(1.0, _WORKING_PX / max(image.shape))
    if scale < 1:
        image = np.asarray(cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA))
    low, high = np.percentile(image, (0.5, 99.5))
    return np.asarray(np.clip((image - low) * (255 / max(high - low, 1e-6)), 0, 255), np.uint8), scale


def _corners(grey: NDArray[np.uint8], size: tuple[int, int]) -> NDArray[np.float32] | None:
    if (glanced := _at_a_glance(grey, size)) is not None:
        return glanced
    seen, corners = cv2.findChessboardCornersSB(grey, size)
    return np.asarray(corners, np.float32) if seen else None


def _at_a_glance(grey: NDArray[np.uint8], size: tuple[int, int]) -> NDArray[np.float32] | None:
    seen, corners = cv2.findChessboardCorners(
        grey, size, flags=cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_FAST_CHECK
    )
    return np.asarray(corners, np.float32) if seen else None


def _unscaled(corners: ArrayLike, scale: float) -> NDArray[np.float32]:
    return np.asarray((np.asarray(corners).reshape(-1, 2) + 0.5) / scale - 0.5, np.float32)
