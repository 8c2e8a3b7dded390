"""ChArUco boards printed and seen by OpenCV: their layout is read off where the markers stand."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from tacos_gap.captures import read_captures
from tacos_gap.evidence.boards.detection import find_corners
from tacos_gap.photographs.charuco import find_markers, layout_of
from tacos_gap.photographs.importing import import_photographs

CORNERS = np.array(
    [[[90, 70], [560, 60], [610, 420], [50, 400]], [[60, 40], [600, 100], [540, 440], [100, 380]]]
)


def seen(
    squares: tuple[int, int], share: float, dictionary: str, view: int, *, legacy: bool = False
) -> np.ndarray:
    """(480, 640) a board in perspective, a little blurred."""
    tags = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary))
    board = cv2.aruco.CharucoBoard(squares, 40.0, 40.0 * share, tags)
    board.setLegacyPattern(legacy)
    size = squares[0] * 90, squares[1] * 90
    printed = board.generateImage(size)
    flat = np.array([[0, 0], [size[0], 0], [size[0], size[1]], [0, size[1]]], np.float32)
    to_view = cv2.getPerspectiveTransform(flat, CORNERS[view].astype(np.float32))
    image = cv2.warpPerspective(printed, to_view, (640, 480), flags=cv2.INTER_AREA, borderValue=200)
    return cv2.GaussianBlur(image, (0, 0), 0.8)


@pytest.mark.parametrize(
    ("squares", "share", "dictionary", "legacy"),
    [
        ((8, 6), 0.75, "DICT_5X5_50", False),
        ((7, 5), 0.6, "DICT_4X4_50", False),
        ((5, 7), 0.7, "DICT_6X6_50", False),
        ((11, 8), 0.75, "DICT_4X4_50", False),
        ((8, 6), 0.7, "DICT_6X6_50", True),
    ],
)
def test_the_layout_is_read_off_the_markers(squares, share, dictionary, legacy):
    markers = [find_markers(seen(squares, share, dictionary, view, legacy=legacy)) for view in (0, 1)]
    layout = layout_of([found for found in markers if found is not None])
    assert layout is not None
    assert (layout.squares, layout.dictionary, layout.legacy) == (squares, dictionary, legacy)
    assert layout.marker_share == pytest.approx(share, abs=0.02)


def test_markers_on_plain_paper_are_no_board(tmp_path):
    tags = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    page = np.full((480, 640), 230, np.uint8)
    rng = np.random.default_rng(2)
    ids = rng.permutation(40)
    for k, (row, column) in enumerate((r, c) for r in range(3) for c in range(4)):
        y, x = 30 + 145 * row + rng.integers(0, 50), 30 + 150 * column + rng.integers(0, 50)
        page[y : y + 80, x : x + 80] = cv2.aruco.generateImageMarker(tags, int(ids[k]), 80)
    assert find_markers(page) is not None
    assert layout_of([find_markers(page)]) is None


def test_pictures_of_a_charuco_become_boards_that_the_diagnosis_sees(tmp_path):
    Path(tmp_path / "in").mkdir()
    for view in range(2):
        Image.fromarray(seen((8, 6), 0.75, "DICT_5X5_100", view)).save(tmp_path / f"in/{view}.png")
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert [entry["kind"] for entry in found.entries] == ["board", "board"]
    board = found.entries[0]["board"]
    assert (board["pattern"], board["inner_corners"], board["dictionary"]) == (
        "charuco",
        [7, 5],
        "DICT_5X5_50",
    )
    assert board["marker_mm"] == pytest.approx(0.75 * board["square_mm"], rel=0.03)
    corners = [find_corners(capture) for capture in read_captures(tmp_path / "out").captures]
    assert all(each is not None and len(each[0]) >= 30 for each in corners)
