"""A ColorChecker found in a picture: four-sided patches that stand on a lattice of six by four.

OpenCV's own finder (``cv2.mcc``) needs the contrib build before version 5, and misses charts that fill the
picture or are not white-balanced; this one asks for nothing but patches with a border.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.targets.lattice import Lattice, side_of

COLUMNS, ROWS = 6, 4

LIKENESS = 0.75
"""Correlation of a chart's logarithmic colours with its reference above which it is believed: .87 for one
through raw colour filters in the sun, .03 for the same read upside down, below .44 for 10,000 sets of random
colours."""

_SAMPLED = 0.5
"""Share of a patch's side that is read: clear of its border and of blur."""


@dataclass(frozen=True, eq=False)
class FoundChart:
    """Place of a ColorChecker."""

    patches_px: NDArray[np.float64]
    """(24, 4, 2) corners of the patches in the order of the chart, dark skin first [px]."""
    likeness: float  # correlation of its colours with the reference

    def boxes(self) -> NDArray[np.int64]:
        """(24, 4) x, y, width, height of upright boxes well inside the patches [px]."""
        centres = self.patches_px.mean(axis=1)
        sides = np.linalg.norm(np.diff(self.patches_px, axis=1, append=self.patches_px[:, :1]), axis=2)
        first = self.patches_px[:, 1] - self.patches_px[:, 0]
        turn = np.arctan2(first[:, 1], first[:, 0]) % (np.pi / 2)
        size = np.maximum(1, _SAMPLED * sides.min(axis=1) / (np.cos(turn) + np.sin(turn)) * 1.2).astype(int)
        corner = np.rint(centres - (size[:, None] - 1) / 2).astype(int)
        return np.column_stack([corner, size, size]).astype(np.int64)


def read_as_chart(lattice: Lattice, reference: NDArray[np.float64]) -> FoundChart | None:
    """The ColorChecker that a lattice is, whichever way it lies; None where its colours are not a chart's."""
    extent = lattice.places.max(axis=0) + 1
    centres = lattice.quads_px.mean(axis=1)
    best: FoundChart | None = None
    for columns, rows in ((COLUMNS, ROWS), (ROWS, COLUMNS)):
        if extent[0] > columns or extent[1] > rows:
            continue
        for shift in product(range(columns - extent[0] + 1), range(rows - extent[1] + 1)):
            at = lattice.places + np.array(shift)
            homography, _ = cv2.findHomography(at.astype(np.float64), centres, cv2.RANSAC, 3.0)
            if homography is None:
                continue
            for order in _orders(columns, rows):
                corners = _patch_corners(order, lattice.quads_px, at, homography)
                likeness = _likeness(lattice.image, corners, reference)
                if best is None or likeness > best.likeness:
                    best = FoundChart((corners + 0.5) / lattice.scale - 0.5, likeness)
    return best if best is not None and best.likeness > LIKENESS else None


def _orders(columns: int, rows: int) -> list[NDArray[np.int64]]:
    """(24, 2) places of the chart's patches on a lattice, for each way to turn it; it is never mirrored."""
    column, row = (places.ravel() for places in np.meshgrid(np.arange(COLUMNS), np.arange(ROWS)))
    if columns == COLUMNS:
        ways = ((column, row), (columns - 1 - column, rows - 1 - row))
    else:
        ways = ((columns - 1 - row, column), (row, rows - 1 - column))
    return [np.column_stack(way) for way in ways]


def _patch_corners(
    order: NDArray[np.int64],
    quads: NDArray[np.float64],
    at: NDArray[np.int64],
    homography: NDArray[np.float64],
) -> NDArray[np.float64]:
    """(24, 4, 2) corners of patches: squares on the lattice as large as those that were seen."""
    centres = cv2.perspectiveTransform(at[None].astype(np.float64), homography)[0]
    steps = cv2.perspectiveTransform((at[None] + [1.0, 0.0]).astype(np.float64), homography)[0] - centres
    half = 0.5 * float(np.median(side_of(quads) / np.linalg.norm(steps, axis=1)))
    square = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], float)
    corners = (order[:, None, :] + square[None]).reshape(1, -1, 2)
    return np.asarray(cv2.perspectiveTransform(corners, homography)[0].reshape(-1, 4, 2))


def _likeness(
    image: NDArray[np.float32], corners: NDArray[np.float64], reference: NDArray[np.float64]
) -> float:
    """Correlation of logarithmic colours with the reference, each channel about its mean."""
    height, width = image.shape[:2]
    boxes = FoundChart(corners, 0.0).boxes()
    if (boxes[:, :2] < 0).any() or (boxes[:, :2] + boxes[:, 2:] > [width, height]).any():
        return -1.0
    seen = np.array([image[y : y + h, x : x + w].mean(axis=(0, 1)) for x, y, w, h in boxes])
    measured, wanted = (
        np.log(np.maximum(colours, 0.01 * colours.max())) for colours in (seen.astype(float), reference)
    )
    measured, wanted = measured - measured.mean(axis=0), wanted - wanted.mean(axis=0)
    return float((measured * wanted).sum() / max(np.linalg.norm(measured) * np.linalg.norm(wanted), 1e-9))
