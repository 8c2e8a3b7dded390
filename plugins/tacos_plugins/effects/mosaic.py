"""Colour filters over the photosites, and full colour reconstructed from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

Plane = NDArray[np.floating]
"""(H, W) samples of a mosaic."""


@lru_cache(maxsize=8)
def mosaic_channels(cfa: str, height_px: int, width_px: int) -> NDArray[np.intp]:
    """The channel that each photosite of a Bayer mosaic samples.

    `cfa`: colours of the 2 x 2 photosites at the top left, row by row: ``"RGGB"``. `height_px`, `width_px`:
    size of the image [px].

    Returns: (H, W), 0 for red, 1 for green, 2 for blue; read-only.

    >>> mosaic_channels("RGGB", 2, 4).tolist()
    [[0, 1, 0, 1], [1, 2, 1, 2]]
    """
    if sorted(cfa) != ["B", "G", "G", "R"]:
        raise ValueError(f"colour filters {cfa!r} are not two G, one R and one B, such as 'RGGB'")
    tile = np.array(["RGB".index(colour) for colour in cfa], np.intp).reshape(2, 2)
    channels = np.tile(tile, (height_px // 2 + 1, width_px // 2 + 1))[:height_px, :width_px]
    channels.flags.writeable = False
    return channels


def mosaic(frame: NDArray[np.floating], cfa: str) -> Plane:
    """Samples of an (H, W, 3) frame under colour filters."""
    channels = mosaic_channels(cfa, *frame.shape[:2])
    return np.take_along_axis(frame, channels[..., None], axis=-1)[..., 0]


def bilinear(plane: Plane, cfa: str) -> NDArray[np.floating]:
    """(H, W, 3): missing colours are means of the nearest photosites that have them."""
    channels = mosaic_channels(cfa, *plane.shape)
    known = (np.where(channels == colour, plane, 0) for colour in range(3))
    return np.stack(
        [_mixed(k, kernel) for k, kernel in zip(known, (_CORNERS, _CROSS, _CORNERS), strict=True)], axis=-1
    )


def gradient_corrected(plane: Plane, cfa: str) -> NDArray[np.floating]:
    """(H, W, 3): bilinear, corrected by the curvature of the colour that is known.

    Source: Malvar, He & Cutler 2004, "High-quality linear interpolation for demosaicing of Bayer-patterned
    color images", ICASSP: the 5 x 5 filters of fig. 2.
    """
    channels = mosaic_channels(cfa, *plane.shape)
    green_missing = _mixed(plane, _MALVAR_GREEN)
    along_row, along_column = _mixed(plane, _MALVAR_ROW), _mixed(plane, _MALVAR_ROW.T)
    opposite = _mixed(plane, _MALVAR_OPPOSITE)
    in_row = {colour: (channels == colour).any(axis=1)[:, None] for colour in (0, 2)}
    full = [plane, np.where(channels == 1, plane, green_missing), plane]
    for colour in (0, 2):
        at_green = np.where(in_row[colour], along_row, along_column)
        elsewhere = np.where(channels == 1, at_green, opposite)
        full[colour] = np.where(channels == colour, plane, elsewhere)
    return np.stack(full, axis=-1)


def edge_aware(plane: Plane, cfa: str) -> NDArray[np.floating]:
    """(H, W, 3): green along the edge rather than across it, then red and blue by their distance from green.

    Source: Hamilton & Adams 1997, US patent 5,629,734 (expired): gradients of green plus curvature of red or
    blue.
    """
    channels = mosaic_channels(cfa, *plane.shape)
    across, down = ((_mixed(plane, k), _mixed(plane, c)) for k, c in (_ROW_PARTS, _COLUMN_PARTS))
    curves = [curvature for _, curvature in (across, down)]
    slopes = [np.abs(_mixed(plane, k)) for k in (_ROW_SLOPE, _ROW_SLOPE.T)]
    edges = [slope + np.abs(curve) for slope, curve in zip(slopes, curves, strict=True)]
    estimates = [mean + curve / 4 for mean, curve in (across, down)]
    choice = np.where(edges[0] < edges[1], estimates[0], estimates[1])
    choice = np.where(edges[0] == edges[1], (estimates[0] + estimates[1]) / 2, choice)
    green = np.where(channels == 1, plane, choice)
    full = [green, green, green]
    for colour in (0, 2):
        full[colour] = green + _mixed(np.where(channels == colour, plane - green, 0), _CORNERS)
    return np.stack(full, axis=-1)


METHODS: Mapping[str, Callable[[Plane, str], NDArray[np.floating]]] = {
    "bilinear": bilinear,
    "gradient-corrected": gradient_corrected,
    "edge-aware": edge_aware,
}
"""Ways from a mosaic to full colour; all keep the samples that were taken."""


def _mixed(plane: Plane, kernel: NDArray[np.float64]) -> Plane:
    # Mirrored about the outermost photosites, the mosaic goes on in step beyond the edges.
    return np.asarray(cv2.filter2D(plane, -1, kernel, borderType=cv2.BORDER_REFLECT_101), plane.dtype)


_CROSS = np.array([[0, 1, 0], [1, 4, 1], [0, 1, 0]]) / 4
_CORNERS = np.array([[1, 2, 1], [2, 4, 2], [1, 2, 1]]) / 4

_MALVAR_GREEN = (
    np.array([[0, 0, -1, 0, 0], [0, 0, 2, 0, 0], [-1, 2, 4, 2, -1], [0, 0, 2, 0, 0], [0, 0, -1, 0, 0]]) / 8
)
_MALVAR_ROW = (
    np.array([[0, 0, 0.5, 0, 0], [0, -1, 0, -1, 0], [-1, 4, 5, 4, -1], [0, -1, 0, -1, 0], [0, 0, 0.5, 0, 0]])
    / 8
)
_MALVAR_OPPOSITE = (
    np.array(
        [[0, 0, -1.5, 0, 0], [0, 2, 0, 2, 0], [-1.5, 0, 6, 0, -1.5], [0, 2, 0, 2, 0], [0, 0, -1.5, 0, 0]]
    )
    / 8
)

_ROW_SLOPE = np.array([[-1.0, 0.0, 1.0]])
_ROW_PARTS = np.array([[0.5, 0.0, 0.5]]), np.array([[-1.0, 0.0, 2.0, 0.0, -1.0]])
_COLUMN_PARTS = _ROW_PARTS[0].T, _ROW_PARTS[1].T
