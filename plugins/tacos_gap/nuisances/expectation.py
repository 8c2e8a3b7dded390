"""An expectation as it would be with other light, pose and focus."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_framework import ImageGeometry
from tacos_framework.camera import Places, resample
from tacos_gap.captures import RealCapture
from tacos_gap.captures.capture import Unmoved
from tacos_gap.nuisances.freedom import LIGHT_TERMS, POSE_TERMS, Freedom
from tacos_gap.nuisances.mosaic import of_each_plane, resampled_mosaic


def disturbed(capture: RealCapture, freedoms: Sequence[Freedom], nu: NDArray[np.float64]) -> RealCapture:
    """The capture with its expectation moved, blurred and lit by nuisances; itself where all are 0.

    `nu`: (F,) their values, in standard deviations of the priors.
    """
    if not np.any(nu):
        return capture
    assert capture.expected_dn is not None
    value = {(f.name, f.channel): float(n * f.sigma) for f, n in zip(freedoms, nu, strict=True)}
    black = np.float32(capture.context.black_level_dn)
    signal = capture.expected_dn - black
    mosaic = capture.context.cfa is not None
    if blur_px2 := value.get(("blur_px2", None)):
        signal = np.stack([_defocused(frame, blur_px2, mosaic) for frame in signal])
    if light := _light(value, signal.shape[1:]):
        for factor in light:
            signal = signal * factor
    still = np.asarray(signal + black, np.float32)
    if not any(value.get((name, None)) for name in POSE_TERMS):
        return replace(capture, expected_dn=still, unmoved=None)
    dx_px, dy_px, *turned = (value[name, None] for name in POSE_TERMS)
    source = looks_at(homography(capture.geometry, (dx_px, dy_px), *turned), still.shape[1:3])
    if mosaic:
        return replace(capture, expected_dn=resampled_mosaic(still, source))
    return replace(capture, expected_dn=resample(still, *source), unmoved=Unmoved(still, source))


def homography(
    geometry: ImageGeometry,
    shift_px: tuple[float, float],
    rotation_deg: float,
    scale: float,
    tilt_x_deg: float,
    tilt_y_deg: float,
) -> NDArray[np.float64]:
    """(3, 3) map of points of the expectation to those of the picture, of a plane that hangs otherwise.

    A plane tilted by a small angle shows a point at (x, y) about the principal point at (x, y) / (1 + x
    tan(tilt) / f), for a tilt along x (Hartley and Zisserman 2004, 8.1).

    - `shift_px`: along x and y.
    - `rotation_deg`: about the optical axis.
    - `scale`: magnification less 1.
    - `tilt_x_deg`, `tilt_y_deg`: by which the plane recedes along x and y.
    """
    turn = np.radians(rotation_deg)
    cos, sin = (1 + scale) * np.cos(turn), (1 + scale) * np.sin(turn)
    kx, ky = np.tan(np.radians([tilt_x_deg, tilt_y_deg])) / geometry.focal_length_px
    (cx, cy), (dx, dy) = geometry.centre_px, shift_px
    about_centre = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [kx, ky, 1.0]])
    return _moved(cx + dx, cy + dy) @ about_centre @ _moved(-cx, -cy)


def _moved(x: float, y: float) -> NDArray[np.float64]:
    return np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])


def looks_at(matrix: NDArray[np.float64], shape: tuple[int, ...]) -> Places:
    """(H, W) columns and rows that a (3, 3) homography takes to the pixels of a picture [px]."""
    x, y = np.arange(shape[1], dtype=float), np.arange(shape[0], dtype=float)[:, None]
    inverse = np.linalg.inv(matrix)
    column, row, depth = (a * x + b * y + c for a, b, c in inverse / inverse[2, 2])
    return column / depth, row / depth


def _defocused(frame: NDArray[np.float32], variance_px2: float, mosaic: bool) -> NDArray[np.float32]:
    if not mosaic:
        return _blurred(frame, variance_px2)
    return of_each_plane(frame, lambda plane: _blurred(plane, variance_px2 / 4))


def _blurred(frame: NDArray[np.float32], variance_px2: float) -> NDArray[np.float32]:
    """Convolved with three taps of exactly this variance along each axis; a negative one sharpens."""
    import cv2

    taps = np.array([variance_px2 / 2, 1 - variance_px2, variance_px2 / 2])
    blurred = cv2.sepFilter2D(frame, cv2.CV_32F, taps, taps, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(blurred, np.float32).reshape(frame.shape)


def _light(value: dict[tuple[str, int | None], float], shape: tuple[int, ...]) -> list[NDArray[np.float32]]:
    """Factors on the signal: a gain per channel and an (H, W, 1) field."""
    found: list[NDArray[np.float32]] = []
    gains = [1 + v for (name, _), v in value.items() if name == "gain"]
    if gains:
        found.append(np.asarray(gains, np.float32))
    if any(value.get((name, None)) for name in LIGHT_TERMS):
        height, width = shape[:2]
        y, x = np.linspace(-1, 1, height)[:, None], np.linspace(-1, 1, width)[None, :]
        terms = (x + 0 * y, y + 0 * x, x * y, x**2 - y**2)
        field = 1 + sum(value[name, None] * term for name, term in zip(LIGHT_TERMS, terms, strict=True))
        found.append(np.asarray(np.maximum(field, 0.0), np.float32)[:, :, None])
    return found
