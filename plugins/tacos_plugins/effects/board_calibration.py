"""Lenses calibrated from views of boards by OpenCV: where the search for a lens begins.

Source: Zhang 2000, "A flexible new technique for camera calibration", IEEE Trans. PAMI 22(11).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Captures, ObservedCapture

WIDEST_FOCAL = 0.15
LONGEST_FOCAL = 30.0
"""Focal lengths over the half diagonal beyond which a calibration went astray."""

_FOCAL_STARTS = (1.0, 0.5, 2.5)
"""Focal lengths over the believed one from which an unknown one is looked for."""


@dataclass(frozen=True)
class Calibration:
    """The camera that fits the corners of boards best."""

    focal_px: float
    """Focal length [px]."""
    moved_px: tuple[float, float]
    """Its principal point, from the believed one to the right and downwards [px]."""
    radial: tuple[float, float, float]
    """k1, k2, k3 of Brown and Conrady, or of the fisheye model [1]."""
    rms_px: float
    """Root mean square distance of the corners from it [px]."""


def calibrated(
    captures: Captures, *, terms: int = 2, free: Collection[str] = (), fisheye: bool = False
) -> Calibration | None:
    """The lens that explains views of boards best; None without views, or where none was found.

    - `captures`: those with `corners` are used.
    - `terms`: radial coefficients, 0 to 3; the others are 0.
    - `free`: focal_length and principal_point where they are not those of the captures' geometry.
    - `fisheye`: OpenCV's fisheye model in place of Brown and Conrady's.
    """
    boards = _Boards.of(captures)
    if boards is None or not all(capture.geometry.lens.is_pinhole for capture in captures):
        return None  # a lens that is known is no start for OpenCV's, which begin at a pinhole
    starts = _FOCAL_STARTS if "focal_length" in free else (1.0,)
    solve = _fisheye if fisheye else _brown
    found = [each for start in starts if (each := solve(boards, boards.focal_px * start, terms, free))]
    return min(found, key=lambda each: each.rms_px, default=None)


@dataclass(frozen=True, eq=False)
class _Boards:
    """Points of boards and where they are seen, from a centre that is the same for all crops."""

    points_mm: Sequence[NDArray[np.float32]]
    corners_px: Sequence[NDArray[np.float32]]
    focal_px: float
    middle_px: float

    @classmethod
    def of(cls, captures: Captures) -> _Boards | None:
        seen = list(_seen(captures))
        if not seen:
            return None
        reach = max(float(np.abs(places).max()) for _, places, _ in seen) + 1
        middle = float(np.ceil(reach))  # OpenCV wants a principal point inside the image
        return cls(
            [points.astype(np.float32) for points, _, _ in seen],
            [(places + middle).astype(np.float32)[:, None] for _, places, _ in seen],
            seen[0][2].geometry.focal_length_px,
            middle,
        )

    @property
    def size_px(self) -> tuple[int, int]:
        return (int(2 * self.middle_px) + 1,) * 2

    def matrix(self, focal_px: float) -> NDArray[np.float64]:
        return np.array([[focal_px, 0, self.middle_px], [0, focal_px, self.middle_px], [0, 0, 1.0]])

    def has_lens(self, matrix: NDArray[Any], rms_px: float) -> bool:
        f = matrix[0, 0] / (np.sqrt(2) * self.middle_px)
        return bool(np.isfinite(matrix).all() and np.isfinite(rms_px) and WIDEST_FOCAL < f < LONGEST_FOCAL)


def _seen(captures: Captures) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64], ObservedCapture]]:
    for capture in captures:
        if capture.corners is not None:
            points_mm, corners_px = capture.corners
            yield points_mm, corners_px - np.array(capture.geometry.centre_px), capture


def _brown(boards: _Boards, focal_px: float, terms: int, free: Collection[str]) -> Calibration | None:
    flags = cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_FIX_ASPECT_RATIO | cv2.CALIB_ZERO_TANGENT_DIST
    for k, flag in enumerate((cv2.CALIB_FIX_K1, cv2.CALIB_FIX_K2, cv2.CALIB_FIX_K3)):
        flags |= flag if k >= terms else 0
    flags |= 0 if "focal_length" in free else cv2.CALIB_FIX_FOCAL_LENGTH
    flags |= 0 if "principal_point" in free else cv2.CALIB_FIX_PRINCIPAL_POINT
    try:
        rms, matrix, lens, _, _ = cv2.calibrateCamera(
            boards.points_mm,
            boards.corners_px,
            boards.size_px,
            boards.matrix(focal_px),
            np.zeros(5),
            flags=flags,
        )
    except cv2.error:  # views that settle nothing
        return None
    return _calibration(boards, matrix, lens, rms) if boards.has_lens(matrix, rms) else None


def _fisheye(boards: _Boards, focal_px: float, terms: int, free: Collection[str]) -> Calibration | None:
    """OpenCV's own fit, which converges with a free focal length alone; a known one is put in afterwards."""
    names = ["USE_INTRINSIC_GUESS", "RECOMPUTE_EXTRINSIC", "FIX_SKEW", "FIX_K4"]
    names += [f"FIX_K{k}" for k in range(terms + 1, 4)]
    names += [] if "principal_point" in free else ["FIX_PRINCIPAL_POINT"]
    flags = 0
    for name in names:  # OpenCV 5 moved them
        flags |= getattr(cv2.fisheye, f"CALIB_{name}", None) or getattr(cv2, f"CALIB_{name}")
    try:
        rms, matrix, lens, _, _ = cv2.fisheye.calibrate(
            [points[None].astype(np.float64) for points in boards.points_mm],
            [corners.reshape(1, -1, 2).astype(np.float64) for corners in boards.corners_px],
            boards.size_px,
            boards.matrix(focal_px),
            np.zeros((4, 1)),
            flags=flags,
        )
    except cv2.error:  # it gives up where a start is far off
        return None
    if not boards.has_lens(matrix, rms):
        return None
    if "focal_length" not in free:
        lens = _over_focal_length(focal_px, float(matrix[0, 0]), lens.ravel(), boards, terms)
        matrix[[0, 1], [0, 1]] = focal_px
    return _calibration(boards, matrix, lens, rms)


def _over_focal_length(
    focal_px: float, fitted_px: float, lens: NDArray[Any], boards: _Boards, terms: int
) -> NDArray[np.float64]:
    """(4,) coefficients over another focal length that image angles at the same radii, by least squares."""
    widest = max(
        float(np.linalg.norm(corners - boards.middle_px, axis=-1).max()) for corners in boards.corners_px
    )
    angle = np.linspace(0.0, min(widest / fitted_px, 1.5), 64)[1:]
    square = angle**2
    radius = fitted_px * angle * np.polynomial.polynomial.polyval(square, [1.0, *lens])
    powers = focal_px * angle[:, None] * square[:, None] ** np.arange(1, terms + 1)
    found = np.linalg.lstsq(powers, radius - focal_px * angle, rcond=None)[0]
    return np.append(found, np.zeros(4 - terms))


def _calibration(boards: _Boards, matrix: NDArray[Any], lens: NDArray[Any], rms_px: float) -> Calibration:
    k = lens.ravel()
    radial = (k[0], k[1], k[4]) if len(k) >= 5 else (k[0], k[1], k[2])  # tangential ones stand between
    return Calibration(
        float(matrix[0, 0]),
        (float(matrix[0, 2]) - boards.middle_px, float(matrix[1, 2]) - boards.middle_px),
        (float(radial[0]), float(radial[1]), float(radial[2])),
        float(rms_px),
    )
