"""Lenses calibrated from views of boards by OpenCV: where the search for a lens begins.

Source: Zhang 2000, "A flexible new technique for camera calibration", IEEE Trans. PAMI 22(11).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Captures, Lens, ObservedCapture
from tacos_framework.camera import rays_of_pixels
from tacos_plugins.effects.powers_of_angle import powers_beyond

WIDEST_FOCAL = 0.15
LONGEST_FOCAL = 30.0
"""Focal lengths over the half diagonal beyond which a calibration went astray."""

_FOCAL_STARTS = (1.0, 0.5, 2.5)
"""Focal lengths over the believed one from which an unknown one is looked for."""

_LEAST_AHEAD, _FEWEST = 0.15, 8
"""Cosine of the angle off the axis that corners of a known fisheye need for OpenCV's, and their number."""

_ASIDE_RAD = 1.5
"""Angle at which the outermost corner of a fisheye's boards is seen at another start [rad]."""


@dataclass(frozen=True)
class Calibration:
    """The camera that fits the corners of boards best."""

    focal_px: float
    """Focal length [px]."""
    moved_px: tuple[float, float]
    """Its principal point, from the believed one to the right and downwards [px]."""
    radial: tuple[float, float, float, float]
    """k1, k2, k3 of Brown and Conrady, or k1 to k4 of the fisheye model, those beyond a known fisheye [1]."""
    rms_px: float
    """Root mean square distance of the corners from it [px]."""


def calibrated(
    captures: Captures, *, terms: int = 2, free: Collection[str] = (), fisheye: bool = False
) -> Calibration | None:
    """The lens that explains views of boards best; None without views, or where none was found.

    - `captures`: those with `corners` are used.
    - `terms`: radial coefficients, 0 to 3, of a fisheye to 4; the others are 0.
    - `free`: focal_length and principal_point where they are not those of the captures' geometry.
    - `fisheye`: OpenCV's fisheye model in place of Brown and Conrady's, which has no start at a known lens.
    """
    boards = _Boards.of(captures)
    if boards is None or not (boards.lens.is_pinhole or (fisheye and not boards.lens.is_rectilinear)):
        return None
    starts = [boards.focal_px * start for start in (_FOCAL_STARTS if "focal_length" in free else (1.0,))]
    if fisheye and "focal_length" in free:
        starts.append(boards.middle_px / _ASIDE_RAD)
    solve = _fisheye if fisheye else _brown
    with opencv_in_one_thread():
        found = [each for start in starts if (each := solve(boards, start, terms, free))]
    return min(found, key=lambda each: each.rms_px, default=None)


@contextmanager
def opencv_in_one_thread() -> Iterator[None]:
    """Several add up the views as they finish: the last digits then differ from run to run."""
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(before)


@dataclass(frozen=True, eq=False)
class _Boards:
    """Points of boards and where they are seen, from a centre that is the same for all crops."""

    points_mm: Sequence[NDArray[np.float32]]
    corners_px: Sequence[NDArray[np.float32]]
    focal_px: float
    middle_px: float
    lens: Lens
    """The believed one."""

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
            seen[0][2].geometry.lens,
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
            ahead = _are_ahead(corners_px, capture)
            if ahead.sum() >= _FEWEST:
                places = corners_px[ahead] - np.array(capture.geometry.centre_px)
                yield points_mm[ahead], places, capture


def _are_ahead(corners_px: NDArray[np.float64], capture: ObservedCapture) -> NDArray[np.bool_]:
    """(K,) which corners OpenCV's fisheye can take: those well before the camera, by its believed lens."""
    if capture.geometry.lens.is_rectilinear:
        return np.ones(len(corners_px), bool)
    return np.nan_to_num(rays_of_pixels(corners_px, capture.geometry)[:, 2]) > _LEAST_AHEAD


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
    fitted = 4 if not boards.lens.is_pinhole else terms
    names = ["USE_INTRINSIC_GUESS", "RECOMPUTE_EXTRINSIC", "FIX_SKEW"]
    names += [f"FIX_K{k}" for k in range(fitted + 1, 5)]
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
    """(4,) coefficients beyond the believed lens, over another focal length, for the same image."""
    found = Lens("kannala-brandt", tuple(lens))
    widest = max(
        float(np.linalg.norm(corners - boards.middle_px, axis=-1).max()) for corners in boards.corners_px
    )
    widest_rad = float(np.nan_to_num(found.angle(widest / fitted_px), nan=1.5))
    angle = np.linspace(0.0, widest_rad, 64)[1:]
    return np.array(powers_beyond(fitted_px / focal_px * found.radius(angle), angle, boards.lens, terms))


def _calibration(boards: _Boards, matrix: NDArray[Any], lens: NDArray[Any], rms_px: float) -> Calibration:
    k = lens.ravel()
    radial = (k[0], k[1], k[4], 0.0) if len(k) >= 5 else k  # tangential ones stand between
    return Calibration(
        float(matrix[0, 0]),
        (float(matrix[0, 2]) - boards.middle_px, float(matrix[1, 2]) - boards.middle_px),
        (float(radial[0]), float(radial[1]), float(radial[2]), float(radial[3])),
        float(rms_px),
    )
