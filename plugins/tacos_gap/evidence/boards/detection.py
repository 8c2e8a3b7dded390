"""Points of a board in a picture: found in a small one, and refined in the picture itself."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.capture import Board, RealCapture
from tacos_gap.evidence.boards.circles import find_circles
from tacos_gap.evidence.boards.corner_noise import smooth_residual
from tacos_gap.evidence.boards.targets import looks_alike_upside_down, points_of

Corners = tuple[NDArray[np.float64], NDArray[np.float64]]
"""(K, 3) points of the board [mm] and (K, 2) where they are seen [px]."""

SEARCH_PX = 1000
"""Longer side of the picture in which a board is looked for first [px]."""

FEWEST = 8
"""Points that it takes: a pose and a homography are settled by four, and leave something to say from here."""

STRAY = 6.0
"""Standard deviations of the corner noise from a smooth surface beyond which a point was not one."""

_FLAGS = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_FAST_CHECK
_SECTOR_FLAGS = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY
_SMOOTHED_PX = 1.0
"""Blur before corners are refined: gradients of edges as sharp as a pixel pull them by .08 px (rms) towards
places between pixels, and by .04 px after it (ideal pictures of boards before a fisheye)."""
_SMOOTHED_FROM_PX = 4
"""Windows narrower than that would see the blur of other corners."""
_ENOUGH = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 40, 0.001)


def with_corners(captures: Sequence[RealCapture]) -> tuple[tuple[RealCapture, ...], list[str]]:
    """Captures with the points of their boards, and of those whose board was not found what to do."""
    found, said = [], []
    for capture in captures:
        if capture.kind != "board" or capture.corners is not None:
            found.append(capture)
        elif (corners := find_corners(capture)) is None:
            said.append(_not_found(capture))
        else:
            found.append(replace(capture, corners=corners))
    return tuple(found), said


def find_corners(capture: RealCapture) -> Corners | None:
    """The points of a capture's board in the mean of its frames; None where too few are seen.

    Of a ChArUco board those that are seen, of others all. Points far off the smooth surface through their
    neighbours are left out.
    """
    assert capture.board is not None
    grey = grey_of(capture)
    if grey is None:
        return None
    corners = _seen(grey, capture.board)
    if corners is None or len(corners[1]) < FEWEST:
        return None
    residual_px, noise_px = smooth_residual(*corners, capture.geometry.centre_px)
    kept = np.hypot(*residual_px.T) <= STRAY * max(noise_px, 0.1)
    return (corners[0][kept], corners[1][kept]) if kept.sum() >= FEWEST else None


def grey_of(capture: RealCapture) -> NDArray[np.uint8] | None:
    """(H, W) the mean of the frames, its range stretched to eight bits; None where all is one level."""
    image = capture.real_dn.mean(axis=0).mean(axis=-1)
    low, high = np.percentile(image, (0.5, 99.5))
    if high <= low:
        return None
    return np.clip((image - low) * (255 / (high - low)), 0, 255).astype(np.uint8)


def _seen(grey: NDArray[np.uint8], board: Board) -> Corners | None:
    if board.pattern == "charuco":
        return _charuco(grey, board)
    points = points_of(board)
    if board.pattern == "chessboard":
        corners = _chessboard(grey, board.inner_corners)
    else:
        corners = find_circles(grey, board)
    if corners is None:
        return None
    return points, _right_way_up(grey, corners, board)


def _sizes(grey: NDArray[np.uint8]) -> Iterator[tuple[NDArray[np.uint8], float]]:
    """Pictures to look in, each with its scale: a convenient one, the picture itself, a small one."""
    longest = max(grey.shape)
    for wanted in dict.fromkeys(min(size, longest) for size in (SEARCH_PX, 3 * SEARCH_PX, SEARCH_PX // 2)):
        scale = wanted / longest
        size = round(grey.shape[1] * scale), round(grey.shape[0] * scale)
        smaller = grey if scale == 1 else cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
        yield np.asarray(smaller, np.uint8), scale


def _chessboard(grey: NDArray[np.uint8], size: tuple[int, int]) -> NDArray[np.float64] | None:
    for smaller, scale in _sizes(grey):
        found, corners = cv2.findChessboardCorners(smaller, size, flags=_FLAGS)
        if not found:  # slower, and sees through blur, noise and strong distortion
            found, corners = cv2.findChessboardCornersSB(smaller, size, flags=_SECTOR_FLAGS)
        if found:
            corners = np.asarray(corners, np.float64).reshape(-1, 2)
            return _refined(grey, (corners + 0.5) / scale - 0.5, size)
    return None


def _at_a_glance(grey: NDArray[np.uint8], size: tuple[int, int]) -> bool:
    return min(size) >= 3 and bool(cv2.findChessboardCorners(next(_sizes(grey))[0], size, flags=_FLAGS)[0])


def _refined(
    grey: NDArray[np.uint8], corners: NDArray[np.float64], size: tuple[int, int] | None
) -> NDArray[np.float64]:
    """Corners where the gradients around them point away from (Förstner), unless they wander off."""
    spacing = _spacing_px(corners, size)
    reach = int(np.clip(spacing * 0.4, 3, max(11, max(grey.shape) // 150)))
    start = np.ascontiguousarray(corners, np.float32).reshape(-1, 1, 2)
    smooth = cv2.GaussianBlur(grey, (0, 0), _SMOOTHED_PX) if reach >= _SMOOTHED_FROM_PX else grey
    refined = cv2.cornerSubPix(smooth, start.copy(), (reach, reach), (-1, -1), _ENOUGH).reshape(-1, 2)
    wandered = np.hypot(*(refined - corners).T) > reach
    return np.asarray(np.where(wandered[:, None], corners, refined), np.float64)


def _spacing_px(corners: NDArray[np.float64], size: tuple[int, int] | None) -> float:
    """Least distance between neighbours [px]."""
    if size is not None:
        grid = corners.reshape(size[1], size[0], 2)
        return float(min(np.linalg.norm(np.diff(grid, axis=axis), axis=-1).min() for axis in (0, 1)))
    apart = np.linalg.norm(corners[:, None] - corners[None], axis=-1)
    return float(apart[apart > 0].min())


def _charuco(grey: NDArray[np.uint8], board: Board) -> Corners | None:
    columns, rows = board.inner_corners
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
    target = cv2.aruco.CharucoBoard((columns + 1, rows + 1), board.square_mm, board.marker_mm, dictionary)
    best: Corners | None = None
    for legacy in (False, True):  # before OpenCV 4.6 boards of even rows began with a marker
        target.setLegacyPattern(legacy)
        for smaller, scale in _sizes(grey):
            corners, ids, _, _ = cv2.aruco.CharucoDetector(target).detectBoard(smaller)
            if ids is None or len(ids) < FEWEST:
                continue
            places = (np.asarray(corners, np.float64).reshape(-1, 2) + 0.5) / scale - 0.5
            if best is None or len(ids) > len(best[0]):
                best = points_of(board)[np.ravel(ids)], _refined(grey, places, None)
        if best is not None:
            return best
    return None


def _right_way_up(grey: NDArray[np.uint8], corners: NDArray[np.float64], board: Board) -> NDArray[np.float64]:
    """Points in the one order that is the board's: not mirrored, a dark square first where that tells."""
    columns, rows = board.inner_corners
    grid = corners.reshape(rows, columns, 2)
    right, down = grid[0, -1] - grid[0, 0], grid[-1, 0] - grid[0, 0]
    if board.pattern == "asymmetric_circles":
        return corners
    if right[0] * down[1] - right[1] * down[0] < 0:
        grid = grid[::-1]
    if not looks_alike_upside_down(board):
        first, last = (_level(grey, part) for part in (grid[:2, :2], grid[-2:, -2:]))
        if first > last:
            grid = grid[::-1, ::-1]
    return np.ascontiguousarray(grid).reshape(-1, 2)


def _level(grey: NDArray[np.uint8], square: NDArray[np.float64]) -> float:
    x, y = square.reshape(-1, 2).mean(axis=0)
    return float(cv2.getRectSubPix(grey, (3, 3), (float(x), float(y))).mean())


def _not_found(capture: RealCapture) -> str:
    board, grey = capture.board, grey_of(capture)
    assert board is not None
    columns, rows = board.inner_corners
    fewer = (columns - 1, rows - 1)
    if board.pattern == "chessboard" and grey is not None and _at_a_glance(grey, fewer):
        return (
            f"{capture.id}: its board has {fewer[0]} x {fewer[1]} inner corners, not {columns} x {rows}; it "
            f"is left out. Corners between squares count, not squares: correct inner_corners."
        )
    if board.pattern == "charuco":
        remedy = "Make sure of dictionary, square_mm and marker_mm; show more of it, sharp and without shine."
    else:
        remedy = (
            "Make sure that inner_corners counts what is printed, that all of the board and a pale rim are "
            "in view, and that it is sharp and free of shine. Of a charuco parts are enough."
        )
    what = "circles" if "circles" in board.pattern else "inner corners"
    return (
        f"{capture.id}: no {board.pattern} of {columns} x {rows} {what} was found; it is left out. {remedy}"
    )
