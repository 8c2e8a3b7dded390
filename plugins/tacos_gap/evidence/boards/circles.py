"""Grids of circles: found by OpenCV, and their centres taken again as centroids at full size."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.capture import Board

SEARCHES_PX = (1000, 600, 1600)
"""Longer sides of the pictures in which circles are looked for [px]."""


def find_circles(grey: NDArray[np.uint8], board: Board) -> NDArray[np.float64] | None:
    """(K, 2) centres in the board's order, of dark circles or bright ones [px]; None where not all are seen.

    The centre of an ellipse is not quite the image of the circle's; the difference grows with tilt and size
    (Heikkilä 2000, IEEE Trans. PAMI 22(10)), and for circles of less than half their distance stays small.
    """
    kind = cv2.CALIB_CB_ASYMMETRIC_GRID if "asym" in board.pattern else cv2.CALIB_CB_SYMMETRIC_GRID
    longest = max(grey.shape)
    for wanted in dict.fromkeys(min(longest, size) for size in SEARCHES_PX):
        scale = wanted / longest
        smaller = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        for picture in (smaller, 255 - smaller):
            for flags in (kind, kind | cv2.CALIB_CB_CLUSTERING):
                found, centres = cv2.findCirclesGrid(
                    picture, board.inner_corners, flags=flags, blobDetector=_blobs(picture.size)
                )
                if found:
                    places = (np.asarray(centres, np.float64).reshape(-1, 2) + 0.5) / scale - 0.5
                    return _centroids(grey if picture is smaller else 255 - grey, places)
    return None


def _blobs(pixels: int) -> cv2.SimpleBlobDetector:
    """A detector of dark blobs of any size that a board can have in a picture of so many pixels."""
    wanted = cv2.SimpleBlobDetector.Params()
    wanted.minArea, wanted.maxArea = 12.0, pixels / 40
    wanted.minDistBetweenBlobs = 4.0
    return cv2.SimpleBlobDetector.create(wanted)


def _centroids(grey: NDArray[np.uint8], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Centroids of the darkness around places, of what is darker than halfway."""
    apart = np.linalg.norm(places[:, None] - places[None], axis=-1)
    np.fill_diagonal(apart, np.inf)
    found = places.copy()
    for k, (x, y) in enumerate(places):
        reach = max(int(0.5 * apart[k].min()), 3)
        left, top = max(round(x) - reach, 0), max(round(y) - reach, 0)
        part = grey[top : round(y) + reach + 1, left : round(x) + reach + 1].astype(np.float64)
        dark = np.clip((part.min() + part.max()) / 2 - part, 0, None)
        if not dark.any():
            continue
        rows, columns = np.indices(part.shape)
        centre = np.array(
            [left + (columns * dark).sum() / dark.sum(), top + (rows * dark).sum() / dark.sum()]
        )
        if np.hypot(*(centre - places[k])) < reach / 2:
            found[k] = centre
    return found
