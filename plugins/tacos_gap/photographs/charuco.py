"""ChArUco boards in photographs: their dictionary by their markers, their layout by where these stand.

Markers stand row by row in the white squares of a chessboard and count on, so that their places on the paper
are known for every number of columns: the right one maps them to the picture by a homography.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

FEWEST_MARKERS = 4
_FEWEST_TO_FIT = 6
"""Markers in a picture from which on a layout can be wrong: four fit any."""

_SHARES = (0.3, 0.95)
"""Sides of markers over those of squares: larger ones leave no corner to be seen."""


_FAMILIES = {
    "4X4": (50, 100, 250, 1000),
    "5X5": (50, 100, 250, 1000),
    "6X6": (50, 100, 250, 1000),
    "7X7": (50, 100, 250, 1000),
    "ARUCO_ORIGINAL": (),
    "APRILTAG_36h11": (),
}
"""Dictionaries by families; of a family, the smaller are the beginning of the larger."""

_SEARCHED = 250
"""Markers of a family that are looked for: boards with more are rare, and false finds are not."""

_LEAST_PERIMETER = 0.08
"""Of a marker, over the longer side of the picture: smaller ones cannot be read, noise makes thousands."""

_MOST_COLUMNS = 20
_FITS = 0.15
"""Distance over the side of a marker up to which it stands where a layout puts it: curved by a lens."""


@dataclass(frozen=True, eq=False)
class Markers:
    family: str
    corners_px: Mapping[int, NDArray[np.float64]]


@dataclass(frozen=True)
class Layout:
    """A ChArUco board, in squares."""

    squares: tuple[int, int]  # along its rows and columns
    marker_share: float  # side of a marker over that of a square
    dictionary: str
    legacy: bool

    def board(self, square_mm: float = 1.0) -> cv2.aruco.CharucoBoard:
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, self.dictionary))
        board = cv2.aruco.CharucoBoard(self.squares, square_mm, self.marker_share * square_mm, dictionary)
        board.setLegacyPattern(self.legacy)
        return board


def find_markers(grey: NDArray[np.uint8], family: str | None = None) -> Markers | None:
    """The markers of the family that most in a picture are of; None with fewer than `FEWEST_MARKERS`."""
    smooth = np.asarray(cv2.GaussianBlur(grey, (3, 3), 0), np.uint8)
    best: Markers | None = None
    for name in [family] if family else _FAMILIES:
        sizes = _FAMILIES[name]
        dictionary = f"DICT_{name}_{_SEARCHED}" if sizes else f"DICT_{name}"
        detector = cv2.aruco.ArucoDetector(
            cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary)), _parameters()
        )
        corners, ids, rejected = detector.detectMarkers(smooth)
        if ids is not None and len(ids) >= FEWEST_MARKERS:
            seen = {
                int(i): np.asarray(c, float).reshape(4, 2) for i, c in zip(ids.ravel(), corners, strict=True)
            }
            if best is None or len(seen) > len(best.corners_px):
                best = Markers(name, seen)
        if len(corners) + len(rejected) < FEWEST_MARKERS or (best and len(best.corners_px) > len(rejected)):
            break
    return best


def layout_of(pictures: Sequence[Markers]) -> Layout | None:
    """The ChArUco board whose markers pictures show; None where they stand on none."""
    telling = [markers for markers in pictures if len(markers.corners_px) >= _FEWEST_TO_FIT]
    if not telling:
        return None
    family = telling[0].family
    most = max(max(markers.corners_px) for markers in pictures)
    dictionary = next((f"DICT_{family}_{n}" for n in _FAMILIES[family] if n > most), f"DICT_{family}")
    best: tuple[float, Layout] | None = None
    for layout in _layouts(most, dictionary):
        misfits, shares = zip(*(_fit(layout, markers) for markers in telling), strict=True)
        misfit = float(np.median(misfits))
        if best is None or misfit < best[0]:
            share = round(float(np.median(shares)) * 200) / 200
            best = misfit, replace(layout, marker_share=share)
    if best is None or best[0] > _FITS or not _SHARES[0] < best[1].marker_share < _SHARES[1]:
        return None
    return best[1]


def _layouts(most: int, dictionary: str) -> Iterator[Layout]:
    """Boards with just enough rows for a highest marker."""
    for columns in range(4, _MOST_COLUMNS + 1):
        rows = next(r for r in range(1, 2 * most + 4) if columns * r // 2 > most)
        if rows < 4:
            continue
        for legacy in (False, True) if rows % 2 == 0 else (False,):
            yield Layout((columns, rows), 0.5, dictionary, legacy)


def _fit(layout: Layout, markers: Markers) -> tuple[float, float]:
    """Distance of markers from where a layout puts them, over their side; that side over a square's."""
    places = np.asarray(layout.board().getObjPoints(), np.float64)[:, :, :2]
    ids = [i for i in markers.corners_px if i < len(places)]
    if len(ids) < FEWEST_MARKERS or len(ids) < len(markers.corners_px):
        return np.inf, np.nan
    seen = np.array([markers.corners_px[i] for i in ids])
    on_paper = places[ids].mean(axis=1)
    homography, _ = cv2.findHomography(seen.mean(axis=1), on_paper, cv2.RANSAC, 0.3)
    if homography is None:
        return np.inf, np.nan
    flat = cv2.perspectiveTransform(seen.reshape(1, -1, 2), homography)[0].reshape(seen.shape)
    sides = np.linalg.norm(np.roll(flat, -1, axis=1) - flat, axis=2)
    share = float(np.median(sides))
    apart = np.linalg.norm(flat.mean(axis=1) - on_paper, axis=1)
    return float(np.sqrt(np.mean(np.minimum(apart, 1.0) ** 2)) / max(share, 1e-3)), share


def _parameters() -> cv2.aruco.DetectorParameters:
    parameters = cv2.aruco.DetectorParameters()
    parameters.adaptiveThreshWinSizeMin, parameters.adaptiveThreshWinSizeMax = 13, 33
    parameters.adaptiveThreshWinSizeStep = 20
    parameters.minMarkerPerimeterRate = _LEAST_PERIMETER
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    return parameters
