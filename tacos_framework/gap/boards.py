"""Chessboards: corners against a pinhole whose pose is fitted to each view.

Only what no pose can explain is left, so that distance and tilt are never taken for the lens.
"""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework.contracts import formation_order
from tacos_framework.gap.captures import Capture
from tacos_framework.gap.evidence import REPLICATES, Label
from tacos_framework.randomness import generator

CORNER_PX = 0.12
"""Standard deviation of a detected corner [px]."""

AMPLITUDE_PX = 0.16
"""Displacements this small are nobody's concern: boards are not flat to less, nor squares square [px]."""


def find_corners(capture: Capture) -> NDArray[np.float64] | None:
    """(K, 2) corners of the board in the mean of the frames, in its order; None if not all are seen."""
    assert capture.board is not None
    image = capture.real_dn.mean(axis=0).mean(axis=-1)
    low, high = np.percentile(image, (0.5, 99.5))
    if high <= low:
        return None
    grey = np.clip((image - low) * (255 / (high - low)), 0, 255).astype(np.uint8)
    found, corners = cv2.findChessboardCornersSB(
        grey, capture.board.inner_corners, flags=cv2.CALIB_CB_ACCURACY
    )
    if found:
        return np.asarray(corners, np.float64).reshape(-1, 2)
    found, corners = cv2.findChessboardCorners(grey, capture.board.inner_corners)
    if not found:
        return None
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.01)
    return np.asarray(cv2.cornerSubPix(grey, corners, (5, 5), (-1, -1), criteria), np.float64).reshape(-1, 2)


class BoardEvidence:
    """Corners of one view of a board.

    Parameters
    ----------
    capture
        A capture of kind board.
    corners_px
        (K, 2) what `find_corners` saw in it.
    seed
        Seeds the floor.
    """

    def __init__(
        self, capture: Capture, corners_px: NDArray[np.float64], seed: int, replicates: int = REPLICATES
    ):
        assert capture.board is not None
        self.capture = capture
        self.corners_px = corners_px
        columns, rows = capture.board.inner_corners
        grid = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 2)
        self._points_mm = np.column_stack([grid * capture.board.square_mm, np.zeros(len(grid))])
        geometry = capture.geometry
        self._camera = np.array(
            [
                [geometry.focal_length_px, 0, geometry.centre_px[0]],
                [0, geometry.focal_length_px, geometry.centre_px[1]],
                [0, 0, 1],
            ]
        )
        self._sigma_px = np.hypot(CORNER_PX, AMPLITUDE_PX)
        radius = np.hypot(*(corners_px - geometry.centre_px).T) / geometry.half_diagonal_px
        self.labels = [
            Label(
                capture.id,
                "board",
                "board_corners",
                "optics",
                {"radius": [round(float(r), 2)] * 2, "axis": axis},
            )
            for axis in "xy"
            for r in radius
        ]
        self.floor = self._make_floor(seed, replicates)

    def residual(self, effects: Sequence[Any]) -> NDArray[np.float64]:
        """See `tacos_framework.gap.evidence.Evidence`; only effects that move pixels bear on it."""
        places = self.corners_px
        for effect in sorted(effects, key=lambda e: formation_order(type(e)), reverse=True):
            if moves_pixels(effect):
                places = _looked_up(effect.source(self.capture.geometry), places)
        return self._misfit(places)

    def _misfit(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        solved, rotation, shift = cv2.solvePnP(
            self._points_mm, places, self._camera, None, flags=cv2.SOLVEPNP_ITERATIVE
        )
        if not solved:
            return np.full(2 * len(places), 1e3)
        seen = cv2.projectPoints(self._points_mm, rotation, shift, self._camera, None)[0].reshape(-1, 2)
        return np.asarray((places - seen).T.ravel() / self._sigma_px)

    def _make_floor(self, seed: int, replicates: int) -> NDArray[np.float64]:
        """A perfect view with the noise of detection, its pose refitted."""
        rng = generator(seed, "board", self.capture.id)
        _, rotation, shift = cv2.solvePnP(self._points_mm, self.corners_px, self._camera, None)
        perfect = cv2.projectPoints(self._points_mm, rotation, shift, self._camera, None)[0].reshape(-1, 2)
        noise = rng.normal(scale=CORNER_PX, size=(replicates, *perfect.shape))
        return np.stack([self._misfit(perfect + n) for n in noise])


def moves_pixels(effect: Any) -> bool:
    """Whether an effect does nothing but move pixels, and says from where: ``source(geometry)``."""
    source = getattr(effect, "source", None)
    return callable(source) and list(inspect.signature(source).parameters) == ["geometry"]


def _looked_up(source: tuple[NDArray[Any], NDArray[Any]], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where pixels at `places` look, between the whole pixels that `source` gives."""
    x, y = (np.ascontiguousarray(part, np.float32) for part in source)
    at_x, at_y = (np.ascontiguousarray(part, np.float32)[None] for part in places.T)
    found = [
        cv2.remap(part, at_x, at_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)[0] for part in (x, y)
    ]
    return np.column_stack(found).astype(np.float64)
