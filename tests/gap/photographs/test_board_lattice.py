"""Chessboards of any size, counted in pictures of numpy's own, however the lens bends them."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tacos_gap.photographs.board_lattice import is_whole, size_of_board
from tacos_gap.photographs.shown import _board

SIZE = (360, 480)


def board(
    columns: int, rows: int, square_px: float, *, barrel: float = 0.0, margin: float = 0.9, x: float = 0.5
):
    """A board of so many inner corners on paper before something dark, its middle at a share of the width.

    A ray at the radius r from the middle of the picture shows what lies at r (1 + barrel r^2).
    """
    v, u = (np.mgrid[: SIZE[0], : SIZE[1]] - np.array(SIZE)[:, None, None] / 2) / (SIZE[1] / 2)
    bent = 1 + barrel * (u**2 + v**2)
    across = (u * bent - (2 * x - 1)) * SIZE[1] / 2 / square_px + (columns + 1) / 2
    down = v * bent * SIZE[1] / 2 / square_px + (rows + 1) / 2
    inside = (across > 0) & (across < columns + 1) & (down > 0) & (down < rows + 1)
    paper = (
        (across > -margin) & (across < columns + 1 + margin) & (down > -margin) & (down < rows + 1 + margin)
    )
    light = np.where((np.floor(across) + np.floor(down)) % 2 == 1, 0.8, 0.05)
    light = np.where(inside, light, np.where(paper, 0.8, 0.2))
    noisy = cv2.GaussianBlur(light, (0, 0), 0.7) * 255 + np.random.default_rng(1).normal(0, 2, SIZE)
    return np.clip(noisy, 0, 255).astype(np.uint8)


@pytest.mark.parametrize("barrel", [0.2, 0.35, 0.7])
def test_all_of_a_board_is_counted_of_which_a_lens_bends_most(barrel):
    """OpenCV alone counts 12 x 3 of it at the strongest barrel."""
    assert _board(board(15, 11, 24 * (1 + 0.5 * barrel), barrel=barrel)) == (15, 11)


def test_of_a_board_that_leaves_the_picture_what_is_seen_is_counted():
    columns, rows = _board(board(9, 6, 40, x=0.9))
    assert (columns, rows) == (6, 6)


@pytest.mark.parametrize("margin", [0.0, 0.9])
def test_where_a_board_ends_is_no_row_of_corners(margin):
    """Squares meet paper there, or what is behind."""
    image = board(7, 5, 40, margin=margin)
    middle = np.array([SIZE[1] / 2, SIZE[0] / 2]) - 0.5
    places = np.stack(np.meshgrid(np.arange(7) - 3.0, np.arange(6) - 2.0), axis=-1)
    with_false_row = middle + 40 * places
    assert size_of_board(image, with_false_row) == (7, 5)
    assert not is_whole(image, with_false_row)
    assert is_whole(image, with_false_row[:5])
