"""Targets are found in pictures drawn by other means, to a fraction of a pixel; what is missing is said."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from tacos_gap.captures import Board
from tacos_gap.evidence.boards.detection import find_corners, with_corners
from tacos_gap.evidence.boards.targets import points_of
from tests.gap.evidence.boards.drawn_boards import (
    SQUARES,
    board_capture,
    chessboard,
    developed,
    photographed,
    points,
    pose,
    seen,
)

FOCAL_PX = 536.0
MIDDLE = np.array([100.0, 62.5, 0.0])


def view(tilt=(15, -10), distance_mm=330.0, roll_deg=0.0, board=SQUARES, focal_px=FOCAL_PX, **lens):
    """A picture of a chessboard and where its corners are."""
    turned, shift = pose(tilt, distance_mm, points(board).mean(axis=0), roll_deg)
    rim = -2.0 * board.square_mm
    drawn = {k: v for k, v in lens.items() if k in ("size", "oversampling", "brown", "fisheye")}
    picture = photographed(
        chessboard(board), 40 / board.square_mm, (rim, rim), turned, shift, focal_px, **drawn
    )
    return picture, (turned, shift)


@pytest.mark.parametrize("roll_deg", [0, 30, 170])
def test_corners_are_found_in_the_boards_own_order(roll_deg):
    picture, where = view(roll_deg=roll_deg)
    found = find_corners(board_capture(image=developed(picture, np.random.default_rng(1))))
    assert found is not None
    assert np.array_equal(found[0], points_of(SQUARES))
    assert np.abs(found[1] - seen(*where, found[0], FOCAL_PX)).max() < 0.25


def test_a_blurred_view_through_a_fisheye_is_found():
    lens = (0.02, 0.0, 0.0, 0.0)
    picture, where = view((30, 20), 170.0, focal_px=280.0, fisheye=lens)
    found = find_corners(board_capture(image=developed(picture, np.random.default_rng(2), blur_px=2.0)))
    assert found is not None
    assert np.abs(found[1] - seen(*where, found[0], 280.0, fisheye=lens)).max() < 0.5


def test_a_large_photograph_is_searched_small_and_measured_large():
    turned, shift = pose((20, 10), 330.0, MIDDLE)
    size, focal = (1920, 1440), 3 * FOCAL_PX
    picture = photographed(
        chessboard(SQUARES), 1.6, (-50.0, -50.0), turned, shift, focal, size=size, oversampling=1
    )
    found = find_corners(board_capture(image=developed(picture, np.random.default_rng(3), blur_px=2.0)))
    assert found is not None
    truth = (seen(turned, shift, found[0], FOCAL_PX) + 0.5) * 3 - 0.5
    assert np.abs(found[1] - truth).max() < 0.6


CHARUCO = Board((6, 4), 30.0, "charuco", marker_mm=22.0, dictionary="DICT_5X5_50")


def charuco_texture() -> np.ndarray:
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_50)
    target = cv2.aruco.CharucoBoard((7, 5), 30.0, 22.0, dictionary)
    return np.where(target.generateImage((840, 600), marginSize=0) > 128, 200.0, 30.0)


@pytest.mark.parametrize("aside_mm", [0.0, 90.0])
def test_of_a_charuco_parts_are_enough(aside_mm):
    turned, shift = pose((10, 20), 260.0, np.array([105.0, 75.0, 0.0]))
    shift[0] += aside_mm
    picture = photographed(charuco_texture(), 4.0, (0.0, 0.0), turned, shift, FOCAL_PX)
    found = find_corners(board_capture(image=developed(picture, np.random.default_rng(4)), board=CHARUCO))
    assert found is not None
    assert len(found[0]) == 24 if not aside_mm else 8 <= len(found[0]) < 24
    assert np.abs(found[1] - seen(turned, shift, found[0], FOCAL_PX)).max() < 0.4


@pytest.mark.parametrize("pattern", ["circles", "asymmetric_circles"])
@pytest.mark.parametrize("bright", [False, True])
def test_grids_of_circles(pattern, bright):
    board = Board((4, 11) if pattern == "asymmetric_circles" else (7, 5), 30.0, pattern)
    where = points_of(board)
    texture = np.full((1100, 1300), 200.0)
    for x, y, _ in where:
        cv2.circle(texture, (round((x + 50) * 4), round((y + 50) * 4)), 26, 30.0, -1, cv2.LINE_AA)
    texture = 230 - texture if bright else texture
    turned, shift = pose((12, -14), 420.0, where.mean(axis=0))
    picture = photographed(texture, 4.0, (-50.125, -50.125), turned, shift, FOCAL_PX)
    found = find_corners(board_capture(image=developed(picture, np.random.default_rng(5)), board=board))
    assert found is not None
    nearest = np.linalg.norm(found[1][:, None] - seen(turned, shift, where, FOCAL_PX)[None], axis=-1)
    assert nearest.min(axis=1).max() < 0.4
    homography, _ = cv2.findHomography(found[0][:, :2], found[1])
    mapped = cv2.perspectiveTransform(found[0][None, :, :2], homography)[0]
    assert np.abs(mapped - found[1]).max() < 0.5  # in the board's order


def test_a_corner_that_is_none_is_left_out():
    picture, where = view((5, 5), 330.0)
    places = np.rint(seen(*where, points(SQUARES), FOCAL_PX)[20]).astype(int)
    files = developed(picture, np.random.default_rng(6), quality=None)
    files[places[1] - 2 : places[1] + 9, places[0] - 3 : places[0] + 8] = 215.0  # a shining spot
    found = find_corners(board_capture(image=files))
    if found is not None:  # finding none is right too
        truth = seen(*where, found[0], FOCAL_PX)
        assert np.abs(found[1] - truth).max() < 0.5


def test_a_picture_without_a_board_gives_no_corners():
    noise = np.random.default_rng(1).normal(100, 5, (480, 640)).astype(np.float32)
    assert find_corners(board_capture(image=noise)) is None
    assert find_corners(board_capture(image=np.full((480, 640), 7, np.float32))) is None


def test_what_was_not_found_is_said_with_a_remedy():
    picture, _ = view()
    files = developed(picture, np.random.default_rng(7))
    squares_counted = board_capture("counted", files, board=Board((10, 7), 25.0))
    nothing = board_capture("nothing", np.full((480, 640), 7, np.float32))
    charuco = replace(nothing, id="markers", board=CHARUCO)
    kept, said = with_corners([squares_counted, nothing, charuco, board_capture("good", files)])
    assert [capture.id for capture in kept] == ["good"]
    assert said[0] == (
        "counted: its board has 9 x 6 inner corners, not 10 x 7; it is left out. Corners between squares "
        "count, not squares: correct inner_corners."
    )
    assert said[1].startswith(
        "nothing: no chessboard of 9 x 6 inner corners was found; it is left out. Make sure that"
    )
    assert "dictionary" in said[2]
