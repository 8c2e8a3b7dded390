"""Cube maps: what is seen from a place in every direction, kept for all cameras that are put there.

Pitch, focal length, sensor and pixels do not move the optical centre, so candidates of a study see the same
panorama. Faces are drawn when a camera first looks at them.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera
from tacos_plugins.renderers.moderngl.rendered_views import RenderedView

LEVELS = 3
"""Resolutions of a face's luminance, each half of the one before."""

MARGIN_PX = 8
"""Pixels of a face beyond its 90 degrees, so that neighbouring faces meet without a seam [px]."""


@dataclass(frozen=True, eq=False)
class Face:
    """One side of a cube map, a square of ``edge_px + 2 MARGIN_PX`` pixels P."""

    luminance_cd_m2: tuple[NDArray[np.float32], ...]
    """`LEVELS` arrays of (P / 2^n, P / 2^n, 3) float32 [cd/m2]."""
    nearness: NDArray[np.float32]
    """(P, P) float32 1 / depth: linear across planes, 0 for nothing [1/m]."""
    surface: NDArray[np.float32]
    """(P, P) float32 numbers of the surfaces seen."""

    @property
    def size_bytes(self) -> int:
        return sum(held.nbytes for held in (*self.luminance_cd_m2, self.nearness, self.surface))


def face_of(picture: RenderedView) -> Face:
    """The face that a picture through `cube_camera` shows."""
    levels = [picture.luminance_cd_m2]
    for _ in range(LEVELS - 1):
        half = cv2.resize(levels[-1], None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        levels.append(half.astype(np.float32, copy=False))
    return Face(tuple(levels), np.float32(1) / picture.depth_m, picture.surface.copy())


def cube_camera(edge_px: int) -> Camera:
    """Camera of a face with 90 degrees across ``edge_px`` pixels, and a margin around them.

    >>> camera = cube_camera(64)
    >>> camera.width_px, camera.focal_length_px
    (80, 32.0)
    """
    size = edge_px + 2 * MARGIN_PX
    return Camera("face", size, size, pixel_um=1.0, focal_length_mm=edge_px / 2 * 1e-3)


class FaceStore:
    """Faces by what they show; those used longest ago go when the memory is full.

    - `most_bytes`: memory that may be held; the face asked for last is always kept [bytes].
    """

    def __init__(self, most_bytes: int):
        self.most_bytes = most_bytes
        self._faces: OrderedDict[Hashable, Face] = OrderedDict()
        self._held_bytes = 0

    @property
    def held_bytes(self) -> int:
        return self._held_bytes

    def get(self, key: Hashable, make: Callable[[], Face]) -> Face:
        """The face of a key, made where it is not held."""
        if key not in self._faces:
            self._faces[key] = make()
            self._held_bytes += self._faces[key].size_bytes
            while self._held_bytes > self.most_bytes and len(self._faces) > 1:
                self._held_bytes -= self._faces.popitem(last=False)[1].size_bytes
        self._faces.move_to_end(key)
        return self._faces[key]
