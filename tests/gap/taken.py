"""Captures of a small camera, taken by the simulator itself with effects left out of what is expected."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework.formation import EpisodeDraws, PlacedEffect
from tacos_framework.plugins import Plugins
from tacos_framework.values import ImageContext, ImageGeometry
from tacos_gap.captures import Board, Noise, RealCapture
from tacos_gap.simulation.formation import simulate

WIDTH, HEIGHT = 160, 120
BLACK_DN = 16.0
GEOMETRY = ImageGeometry(WIDTH, HEIGHT, 170.0, ((WIDTH - 1) / 2, (HEIGHT - 1) / 2), 12.0)


def effect(plugins: Plugins, name: str, **settings: Any) -> PlacedEffect:
    """An effect as a recipe would place it."""
    use = f"effect.{name}"
    cls = plugins.resolve(use)
    return PlacedEffect(use, use, cls, cls.Config(**settings))


def capture(kind: str, level: float | NDArray[Any], *, frames: int = 2, channels: int = 1) -> RealCapture:
    """A capture with expected values and no real frames yet; `level` is above the pedestal [DN]."""
    signal = np.broadcast_to(np.asarray(level, np.float32), (HEIGHT, WIDTH))
    expected = np.repeat(signal[None, :, :, None] + np.float32(BLACK_DN), channels, axis=3)
    return RealCapture(
        id=f"{kind}_{round(float(np.mean(level)))}",
        kind=kind,
        real_dn=np.zeros((frames, HEIGHT, WIDTH, channels), np.float32),
        expected_dn=expected,
        valid=np.ones((HEIGHT, WIDTH), bool),
        geometry=GEOMETRY,
        context=ImageContext(exposure_s=0.01, black_level_dn=BLACK_DN, white_level_dn=255.0, f_number=2.8),
        noise=Noise((0.24,) * channels, (1.8,) * channels),
    )


def taken(
    captures: Sequence[RealCapture], effects: Sequence[PlacedEffect], seed: int = 3
) -> list[RealCapture]:
    """The captures with real frames, from a camera that has these effects."""
    return [
        replace(each, real_dn=simulate(each, effects, EpisodeDraws(seed, ("taken", i))))
        for i, each in enumerate(captures)
    ]


def patchwork() -> NDArray[np.float32]:
    """(H, W) overlapping rectangles in all directions, a scene with corners [DN above the pedestal]."""
    rng = np.random.default_rng(1)
    image = np.full((HEIGHT, WIDTH), 90.0, np.float32)
    for _ in range(60):
        centre = float(rng.uniform(0, WIDTH)), float(rng.uniform(0, HEIGHT))
        size = float(rng.uniform(8, 40)), float(rng.uniform(8, 40))
        corners = cv2.boxPoints((centre, size, float(rng.uniform(0, 90))))
        cv2.fillPoly(image, [corners.astype(np.int32)], float(rng.uniform(10, 200)), lineType=cv2.LINE_AA)
    return np.asarray(cv2.GaussianBlur(image, (0, 0), 0.6))


def board(turn_deg: float, barrel: float = 0.3) -> RealCapture:
    """A view of a chessboard of 6 x 4 inner corners, turned about its upright axis, through a bent lens."""
    square_px = 40
    rows, columns = np.mgrid[: 7 * square_px, : 9 * square_px] // square_px
    drawn = 20 + 180 * ((rows + columns) % 2).astype(np.float32)
    drawn[:square_px], drawn[-square_px:], drawn[:, :square_px], drawn[:, -square_px:] = (200,) * 4
    turn = cv2.Rodrigues(np.radians([8.0, turn_deg, 3.0]))[0]
    camera = np.array([[GEOMETRY.focal_length_px, 0, 79.5], [0, GEOMETRY.focal_length_px, 59.5], [0, 0, 1]])
    shift = np.array([0.0, 0.0, 11.0])
    to_board = np.array([[1 / square_px, 0, -4.5], [0, 1 / square_px, -3.5], [0, 0, 1]])
    plane = camera @ np.column_stack([turn[:, 0], turn[:, 1], shift]) @ to_board
    straight = cv2.warpPerspective(drawn, plane, (WIDTH, HEIGHT), flags=cv2.INTER_AREA, borderValue=200)
    x, y = (GEOMETRY.x_px / 170.0, GEOMETRY.y_px / 170.0)
    bend = 1 + barrel * (x**2 + y**2)
    bent = cv2.remap(
        straight,
        (x * bend * 170 + 79.5).astype(np.float32),
        (y * bend * 170 + 59.5).astype(np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )
    return replace(
        capture("board", 0.0, frames=1),
        id=f"board_{round(turn_deg)}",
        expected_dn=None,
        real_dn=np.rint(bent)[None, :, :, None],
        board=Board((6, 4), 1000.0),
    )
