"""What files say of a lens is where the search begins, and the fullest board is the board."""

from __future__ import annotations

from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from tacos_gap.captures.entries import CaptureCamera
from tacos_gap.captures.lens_and_sensor import unstated
from tacos_gap.photographs import boards
from tacos_plugins.effects.black_level import BlackLevel
from tests.gap.small_captures import BLACK_DN, capture, taken


@pytest.mark.parametrize(
    ("said", "free"),
    [
        ({}, {"focal_length", "principal_point"}),
        ({"focal_length_mm": 4.0}, {"principal_point"}),
        ({"focal_length_mm": 4.0, "principal_point_px": [320, 240]}, set()),
        ({"principal_point_px": [320, 240]}, {"focal_length"}),
        ({"focal_length_mm": 4.0, "lens_is_a_start": True}, {"focal_length", "principal_point"}),
    ],
)
def test_a_lens_that_is_a_start_stays_free(said, free):
    camera = CaptureCamera.model_validate({"width_px": 640, "height_px": 480, **said})
    assert unstated(camera) == free


def _picture(tmp_path, name, columns, rows, square_px=30):
    """A picture of a chessboard of so many inner corners."""
    cells = np.indices((rows + 1, columns + 1)).sum(axis=0) % 2 * 200 + 30
    board = np.kron(cells, np.ones((square_px, square_px)))
    image = np.pad(board, 40, constant_values=230).astype(np.uint8)
    path = tmp_path / f"{name}.png"
    cv2.imwrite(str(path), cv2.GaussianBlur(image, (5, 5), 0))
    return path


def test_a_part_of_a_board_is_not_taken_for_it(tmp_path):
    """Most pictures show a part first; all corners are found in them too."""
    pictures = [
        SimpleNamespace(
            path=_picture(tmp_path, name, 9, 6), shown=SimpleNamespace(corners=corners, markers=None)
        )
        for name, corners in (("a", (6, 5)), ("b", (6, 5)), ("c", (9, 6)))
    ]
    (found,) = boards.boards_of([_Hashed(each) for each in pictures], None)
    assert found.inner_corners == (9, 6)
    assert len(found.views) == 3


@pytest.mark.parametrize(("whole", "part"), [((9, 6), (6, 5)), ((8, 6), (7, 5)), ((7, 6), (7, 5))])
def test_a_board_of_which_every_picture_counts_a_part_is_the_usual_one_that_all_show(tmp_path, whole, part):
    pictures = [
        SimpleNamespace(
            path=_picture(tmp_path, name, *whole), shown=SimpleNamespace(corners=part, markers=None)
        )
        for name in "abcdefg"
    ]
    (found,) = boards.boards_of([_Hashed(each) for each in pictures], None)
    assert found.inner_corners == whole
    assert len(found.views) == 7


class _Hashed:
    """A picture, to be looked up by."""

    def __init__(self, picture):
        self.path, self.shown = picture.path, picture.shown


def test_a_pedestal_begins_where_the_darks_lie():
    real = np.random.default_rng(0).normal(BLACK_DN + 26, 1.5, (2, 120, 160, 1)).round().astype(np.float32)
    dark = capture("dark", "dark", BLACK_DN)
    object.__setattr__(dark, "real_dn", real)
    (guess,) = BlackLevel.guesses_from([dark])
    assert guess["offset_dn"] == pytest.approx(26, abs=0.05)
    assert not list(BlackLevel.guesses_from(taken([capture("flat", "flat", 100.0)])))
