"""Takes pictures out of cube maps instead of drawing them."""

from __future__ import annotations

from collections.abc import Hashable

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera
from tacos_plugins.renderers.light.probes import face_rotations
from tacos_plugins.renderers.moderngl.painter import Painter
from tacos_plugins.renderers.moderngl.panorama import LEVELS, MARGIN_PX, Face, FaceStore, face_of
from tacos_plugins.renderers.moderngl.rendered_views import Photographer, RenderedView

_SAME_PLANE = np.float32(
    0.02
)  # interpolated depth is taken where it is this near to that of the nearest pixel
_EDGE_SLACK = 1e-6  # directions between two faces belong to both


class Resampling:
    """Takes pictures from cube maps of the places where they are taken.

    - `place`: what else the faces depend on: world, light, least depth.
    - `edge_px`: pixels across a face [px].
    - `of_faces`: takes the pictures of the faces, through `cube_camera`.
    - `direct`: takes the pictures for which the faces are too coarse, through the camera.
    """

    def __init__(
        self,
        store: FaceStore,
        place: Hashable,
        camera: Camera,
        edge_px: int,
        *,
        of_faces: Photographer,
        direct: Photographer,
    ):
        self._store, self._place, self._edge_px = store, place, edge_px
        self._camera, self._of_faces, self._direct = camera, of_faces, direct
        step = 1 / camera.focal_length_px
        self._x = ((np.arange(camera.width_px) - camera.centre_px[0]) * step).astype(np.float32)
        self._y = ((np.arange(camera.height_px) - camera.centre_px[1]) * step).astype(np.float32)

    def take(self, painter: Painter, world_from_camera: NDArray[np.float64]) -> RenderedView:
        finer = fineness(self._camera, world_from_camera[:3, :3], self._edge_px)
        if finer.min() < 1:
            return self._direct.take(painter, world_from_camera)
        level = int(np.clip(np.floor(np.log2(np.median(finer))), 0, LEVELS - 1))
        size = (self._camera.height_px, self._camera.width_px)
        picture = RenderedView(
            np.zeros((*size, 3), np.float32), np.full(size, np.inf, np.float32), np.zeros(size, np.float32)
        )
        eye_m = world_from_camera[:3, 3]
        for number, rotation in enumerate(face_rotations()):
            turn = (rotation.T @ world_from_camera[:3, :3]).astype(np.float32)
            part = self._part_in(turn)
            if part is None:
                continue

            def make(rotation: NDArray[np.float64] = rotation) -> Face:
                pose = np.eye(4)
                pose[:3, :3], pose[:3, 3] = rotation, eye_m
                return face_of(self._of_faces.take(painter, pose))

            key = (self._place, self._edge_px, eye_m.tobytes(), number)
            self._fill(picture, self._store.get(key, make), level, turn, part)
        return picture

    def _part_in(self, turn: NDArray[np.float32]) -> tuple[slice, slice] | None:
        """Rows and columns of the picture that look into a face, none if none do."""
        x, y, z = self._in_face(turn, (slice(None, None), slice(None, None)))
        inside = _inside(x, y, z)
        rows, columns = np.flatnonzero(inside.any(axis=1)), np.flatnonzero(inside.any(axis=0))
        if len(rows) == 0:
            return None
        return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)

    def _in_face(
        self, turn: NDArray[np.float32], part: tuple[slice, slice]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
        """Rays of depth 1 in the axes of a face: x right, y down, z forward, each (rows, columns) [1]."""
        across, down = self._x[part[1]], self._y[part[0], None]
        x, y, z = (row[0] * across + (row[1] * down + row[2]) for row in turn)
        return x, y, z

    def _fill(
        self,
        picture: RenderedView,
        face: Face,
        level: int,
        turn: NDArray[np.float32],
        part: tuple[slice, slice],
    ) -> None:
        x, y, z = self._in_face(turn, part)
        inside = _inside(x, y, z)
        focal = np.float32(self._edge_px / 2)
        centre = np.float32((self._edge_px - 1) / 2 + MARGIN_PX)
        with np.errstate(divide="ignore", invalid="ignore"):
            column, row = focal * x / z, focal * y / z
        column, row = np.where(inside, column, 0) + centre, np.where(inside, row, 0) + centre

        shrink = np.float32(1 / 2**level)
        middle = np.float32(0.5)  # of a pixel: where halves of the resolution agree
        level_column, level_row = ((along + middle) * shrink - middle for along in (column, row))
        luminance = cv2.remap(face.luminance_cd_m2[level], level_column, level_row, cv2.INTER_LINEAR)
        nearest = cv2.remap(face.nearness, column, row, cv2.INTER_NEAREST)
        between = cv2.remap(face.nearness, column, row, cv2.INTER_LINEAR)
        nearness = np.where(np.abs(between - nearest) <= _SAME_PLANE * nearest, between, nearest)
        with np.errstate(divide="ignore"):
            depth = np.float32(1) / (nearness * z)
        picture.luminance_cd_m2[part][inside] = luminance[inside]
        picture.depth_m[part][inside] = depth[inside]
        picture.surface[part][inside] = cv2.remap(face.surface, column, row, cv2.INTER_NEAREST)[inside]


def fineness(camera: Camera, rotation: NDArray[np.float64], edge_px: int) -> NDArray[np.float64]:
    """Number of pixels of a cube map in one of a camera, along one edge, all over its image.

    A pinhole camera of focal length f [px] turns by ``cos(a)^2 / f`` from pixel to pixel at an angle a off
    its axis, and so does a face with its focal length of ``edge_px / 2``.

    `rotation`: (3, 3) axes of the camera in the world, along whose axes the faces look [1]. `edge_px`: pixels
    across a face [px].

    Returns:

    - `fineness`: (81,) on a grid of 9 x 9 rays from corner to corner [1].
    """
    (cx, cy), focal = camera.centre_px, camera.focal_length_px
    x, y = np.meshgrid(
        (np.linspace(0, camera.width_px - 1, 9) - cx) / focal,
        (np.linspace(0, camera.height_px - 1, 9) - cy) / focal,
    )
    rays = np.stack([x, y, np.ones_like(x)], axis=-1).reshape(-1, 3)
    along_face = np.abs(rays @ rotation.T).max(axis=1)
    ratio: NDArray[np.float64] = edge_px / 2 / focal / along_face**2  # |ray|^2 stands in both cosines
    return ratio


def _inside(x: NDArray[np.float32], y: NDArray[np.float32], z: NDArray[np.float32]) -> NDArray[np.bool_]:
    reach = z * np.float32(1 + _EDGE_SLACK)
    return (np.abs(x) <= reach) & (np.abs(y) <= reach) & (z > 0)
