"""Pictures of targets drawn by ways that share nothing with the diagnosis: warps of scipy, rays of OpenCV."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from opencv_undistortion import undistorted
from scipy.ndimage import map_coordinates

from tacos_framework.values import ImageGeometry
from tacos_gap.captures import Board, RealCapture
from tests.gap.small_captures import capture

WIDTH, HEIGHT = 640, 480
CENTRE = ((WIDTH - 1) / 2, (HEIGHT - 1) / 2)
SQUARES = Board((9, 6), 25.0)


def points(board: Board) -> np.ndarray:
    """(K, 3) corners row by row [mm]."""
    rows, columns = np.mgrid[: board.inner_corners[1], : board.inner_corners[0]]
    return np.column_stack([columns.ravel(), rows.ravel(), np.zeros(rows.size)]) * board.square_mm


def pose(tilt_deg: tuple[float, float], distance_mm: float, middle: np.ndarray, roll_deg: float = 0.0):
    """Rotation and translation of a board whose middle lies on the optical axis."""
    turned = np.eye(3)
    for axis, angle in zip(np.eye(3), (*tilt_deg, roll_deg), strict=True):
        turned = turned @ cv2.Rodrigues(axis * np.radians(angle))[0]
    return turned, np.array([0, 0, distance_mm]) - turned @ middle


def matrix(focal_px: float) -> np.ndarray:
    return np.array([[focal_px, 0, CENTRE[0]], [0, focal_px, CENTRE[1]], [0, 0, 1]])


def seen(
    turned: np.ndarray,
    shift: np.ndarray,
    where: np.ndarray,
    focal_px: float,
    *,
    brown: Sequence[float] = (0, 0, 0, 0, 0),
    fisheye: Sequence[float] | None = None,
) -> np.ndarray:
    """(K, 2) places of points by OpenCV's own projections [px]."""
    if fisheye is not None:
        turn, lens = cv2.Rodrigues(turned)[0], np.array(fisheye, float)
        return cv2.fisheye.projectPoints(where[None], turn, shift, matrix(focal_px), lens)[0].reshape(-1, 2)
    return cv2.projectPoints(where, turned, shift, matrix(focal_px), np.array(brown, float))[0].reshape(-1, 2)


def photographed(
    texture: np.ndarray,
    texels_per_mm: float,
    corner_mm: tuple[float, float],
    turned: np.ndarray,
    shift: np.ndarray,
    focal_px: float,
    *,
    fisheye: Sequence[float] | None = None,
    brown: Sequence[float] = (0, 0, 0, 0, 0),
    size: tuple[int, int] = (WIDTH, HEIGHT),
    oversampling: int = 2,
) -> np.ndarray:
    """(H, W) picture of a printed texture on pale ground, by the rays of several samples in a pixel [DN].

    `corner_mm` is where the texture's upper left corner lies on the board.
    """
    width, height = size
    x, y = np.meshgrid(
        (np.arange(width * oversampling) + 0.5) / oversampling - 0.5,
        (np.arange(height * oversampling) + 0.5) / oversampling - 0.5,
    )
    places = np.column_stack([x.ravel(), y.ravel()])[:, None]
    scaled = matrix(focal_px)
    scaled[:2, 2] = (width - 1) / 2, (height - 1) / 2
    if fisheye is not None:
        rays = cv2.fisheye.undistortPoints(places, scaled, np.array(fisheye, float)).reshape(-1, 2)
    elif any(brown):
        rays = undistorted(places, scaled, np.array(brown, float))
    else:
        rays = (places.reshape(-1, 2) - scaled[:2, 2]) / focal_px
    rays = np.column_stack([rays, np.ones(len(rays))])
    normal = turned[:, 2]
    along = (normal @ shift) / (rays @ normal)
    on_board = (rays * along[:, None] - shift) @ turned
    texel = (on_board[:, :2] - corner_mm) * texels_per_mm - 0.5
    levels = map_coordinates(texture.astype(np.float32), texel[:, ::-1].T, order=1, cval=200.0)
    levels = np.where(along > 0, levels, 200.0)
    return levels.reshape(height, oversampling, width, oversampling).mean(axis=(1, 3))


def chessboard(board: Board, texels: int = 40) -> np.ndarray:
    """Texture of a chessboard with a pale rim of one square, `texels` a square [DN]."""
    columns, rows = (n + 1 for n in board.inner_corners)
    squares = np.indices((rows, columns)).sum(axis=0) % 2 == 0
    return np.pad(
        np.where(np.kron(squares, np.ones((texels, texels))) > 0, 30.0, 200.0), texels, constant_values=200
    )


def developed(
    picture: np.ndarray, rng: np.random.Generator, *, blur_px=0.7, noise_dn=2.0, quality: int | None = 85
):
    """A picture after a soft lens, a noisy sensor and JPEG [DN]."""
    soft = cv2.GaussianBlur(picture, (0, 0), blur_px)
    files = np.clip(np.rint(soft + rng.normal(0, noise_dn, soft.shape)), 0, 255).astype(np.uint8)
    if quality is not None:
        files = cv2.imdecode(
            cv2.imencode(".jpg", files, [cv2.IMWRITE_JPEG_QUALITY, quality])[1], cv2.IMREAD_UNCHANGED
        )
    return files.astype(np.float32)


def board_capture(
    name: str = "board",
    image: np.ndarray | None = None,
    *,
    board: Board = SQUARES,
    focal_px: float = 536.0,
    corners: tuple[np.ndarray, np.ndarray] | None = None,
    unstated: Sequence[str] = (),
) -> RealCapture:
    """A capture of a board: a picture of it, or the places of its corners."""
    frame = np.zeros((HEIGHT, WIDTH), np.float32) if image is None else image
    height, width = frame.shape
    return replace(
        capture(name, "board", 0.0, frames=1),
        real_dn=frame[None, ..., None],
        expected_dn=None,
        valid=np.ones((height, width), bool),
        geometry=ImageGeometry(width, height, focal_px, ((width - 1) / 2, (height - 1) / 2), 3.0),
        board=board,
        corners=corners,
        unstated=frozenset(unstated),
    )
