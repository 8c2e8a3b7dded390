"""The chessboard of a set of photographs: its size, by the fullest that many of them show."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_files.camera_images import read_image
from tacos_gap.photographs.picture import Picture

USUAL_SQUARE_MM = 25.0
_CANDIDATES = 3
_MANY = 0.5
"""Pictures that show all of a board, over those that show a part of it, from which on it is the board."""


@dataclass(frozen=True, eq=False)
class BoardFound:
    """A chessboard in several pictures.

    Parameters
    ----------
    inner_corners
        Along its rows and columns.
    corners_px
        For each picture that shows all of it, (K, 2) its corners [px].
    """

    inner_corners: tuple[int, int]
    corners_px: Mapping[Picture, NDArray[np.float32]]


def board_of(pictures: Sequence[Picture], given: tuple[int, int] | None) -> BoardFound | None:
    """The largest board that many pictures show in full, and its corners in them.

    Parameters
    ----------
    pictures
        Those that show a board.
    given
        Its inner corners, where the photographer said them.
    """
    if not pictures:
        return None
    counted = Counter(picture.shown.corners for picture in pictures if picture.shown.corners)
    fullest = sorted(counted, key=lambda size: -size[0] * size[1])[:_CANDIDATES]
    usual = [size for size, _ in counted.most_common(_CANDIDATES)]
    sizes = [given] if given else list(dict.fromkeys([*usual, *fullest]))
    greys = {picture: _grey(picture) for picture in pictures}
    found = [
        BoardFound(
            size, {p: corners for p, grey in greys.items() if (corners := _corners(grey, size)) is not None}
        )
        for size in sizes
    ]
    most = max(len(board.corners_px) for board in found)  # a part of a board is found wherever all of it is
    likely = [board for board in found if len(board.corners_px) >= _MANY * most]
    best = max(likely, key=lambda board: (np.prod(board.inner_corners), len(board.corners_px)))
    return best if best.corners_px else None


def _grey(picture: Picture) -> NDArray[np.uint8]:
    image = np.asarray(read_image(picture.path, str(picture.path)), np.float32).mean(axis=-1)
    low, high = np.percentile(image, (0.5, 99.5))
    return np.asarray(np.clip((image - low) * (255 / max(high - low, 1e-6)), 0, 255), np.uint8)


def _corners(grey: NDArray[np.uint8], size: tuple[int, int]) -> NDArray[np.float32] | None:
    seen, corners = cv2.findChessboardCorners(
        grey, size, flags=cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_FAST_CHECK
    )
    if not seen:
        seen, corners = cv2.findChessboardCornersSB(grey, size)
    return np.asarray(corners, np.float32).reshape(-1, 2) if seen else None
