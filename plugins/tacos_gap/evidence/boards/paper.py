"""Paper that is not flat and squares that are not square: what is the board's, in every view of it.

A lens is fixed to the image and paper to the board. Views that turn the board against the image tell the two
apart; from fewer than `FEWEST_VIEWS` nobody can, and the paper is taken for flat.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.capture import Board
from tacos_gap.evidence.boards.targets import looks_alike_upside_down

FEWEST_VIEWS = 5

SAG = 0.015
"""Standard deviation of how far paper bends, over half the board's diagonal [1]."""

STRETCH = 0.002
"""Standard deviation of how much longer squares are than wide, and of their shear [1]."""

MOST = 6.0
"""Standard deviations beyond which paper does not bend."""


def deformations(board: Board, points_mm: NDArray[np.float64]) -> NDArray[np.float64]:
    """Displacements of a board's points by one standard deviation of each way its paper deforms.

    Two ways in the plane, and out of it the polynomials of second order over the board. Those of third order
    are added where views tell which way up the board is, as they change their sign with it.

    - `points_mm`: (K, 3) its points as printed [mm].

    Returns: (5 or 9, K, 3) displacements [mm].
    """
    columns, rows = board.inner_corners
    half_mm = 0.5 * board.square_mm * float(np.hypot(columns - 1, rows - 1))
    middle = 0.5 * board.square_mm * np.array([columns - 1, rows - 1])
    u, v = (points_mm[:, :2] - middle).T / half_mm
    flat = np.zeros_like(u)
    bends = [u**2, u * v, v**2]
    if not looks_alike_upside_down(board):
        bends += [u**3, u**2 * v, u * v**2, v**3]
    in_plane = [(0.5 * u, -0.5 * v, flat), (0.5 * v, 0.5 * u, flat)]
    moved = [STRETCH * np.column_stack(each) for each in in_plane]
    moved += [SAG * np.column_stack([flat, flat, bend]) for bend in bends]
    return half_mm * np.stack(moved)
