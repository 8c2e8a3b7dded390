"""The points of flat targets, as they are printed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.capture import Board


def points_of(board: Board) -> NDArray[np.float64]:
    """(K, 3) corners or centres of circles on the board, row by row; z is 0 [mm]."""
    columns, rows = board.inner_corners
    x, y = np.meshgrid(np.arange(columns, dtype=np.float64), np.arange(rows, dtype=np.float64))
    if board.pattern == "asymmetric_circles":
        x, y = x + 0.5 * (y % 2), y / 2
    elif board.pattern == "charuco":
        x, y = x + 1, y + 1  # OpenCV counts from the outer corner
    return np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]) * board.square_mm


def looks_alike_upside_down(board: Board) -> bool:
    """True if a view does not show which way up the board is.

    A chessboard turned by half a turn has black where white was if one of its numbers of inner corners is odd
    and the other even.
    """
    if board.pattern == "chessboard":
        return sum(board.inner_corners) % 2 == 0
    return board.pattern == "circles"
