"""Flat scenes before the camera: even fields, textures, edges, charts, boards."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from tacos_validation.blind.generators.camera import IdealCamera, Image

OVERSAMPLING = 2
MARGIN = 0.2
"""Share of the image that a picture reaches beyond each side."""

SOFTNESS_PX = 0.6
"""Blur of a picture: the lens that the simulator knows of [px]."""


@dataclass(frozen=True, eq=False)
class FlatScene:
    """A flat picture before the camera, finer and wider than the image, sampled by cubic splines."""

    coefficients: Image  # (C, h, w) spline coefficients of the light [DN above the pedestal]
    origin_px: tuple[float, float]  # pixel of the image at which its first sample lies

    def __call__(self, x: Image, y: Image, channel: int) -> Image:
        where = (
            (y - self.origin_px[1]) * OVERSAMPLING,
            (x - self.origin_px[0]) * OVERSAMPLING,
        )
        plane = self.coefficients[min(channel, len(self.coefficients) - 1)]
        return np.maximum(ndimage.map_coordinates(plane, where, order=3, mode="mirror", prefilter=False), 0.0)

    def scaled(self, factor: float) -> FlatScene:
        return FlatScene(self.coefficients * factor, self.origin_px)


def canvas_shape(camera: IdealCamera) -> tuple[int, int]:
    reach = 1 + 2 * MARGIN
    return round(camera.height_px * reach * OVERSAMPLING), round(camera.width_px * reach * OVERSAMPLING)


def flat_scene(camera: IdealCamera, canvas: Image) -> FlatScene:
    """A picture of an (h, w, C) canvas of light in DN above the pedestal."""
    planes = [
        ndimage.spline_filter(ndimage.gaussian_filter(canvas[..., c], SOFTNESS_PX * OVERSAMPLING), order=3)
        for c in range(canvas.shape[2])
    ]
    return FlatScene(np.stack(planes), (-MARGIN * camera.width_px, -MARGIN * camera.height_px))


def even(camera: IdealCamera, level: float) -> Callable[[Image, Image, int], Image]:
    """An even field at a share of the range, alike in all channels."""
    return Even(level * camera.range_dn)


@dataclass(frozen=True)
class Even:
    """The same light everywhere [DN above the pedestal]."""

    light_dn: float

    def __call__(self, x: Image, y: Image, channel: int) -> Image:
        return np.full(x.shape, self.light_dn)


def natural(camera: IdealCamera, rng: np.random.Generator, mean: float = 0.35) -> FlatScene:
    """Dead leaves with shading and fine texture: edges of all directions, a spectrum as in nature.

    Source: Lee, Mumford and Huang 2001, "Occlusion models for natural images", IJCV 41.
    """
    height, width = canvas_shape(camera)
    canvas = np.full((height, width, camera.channels), 0.3)
    smallest, largest = 5.0, 0.25 * height
    count = 900
    # radii with a density of r^-3, big leaves below small ones so that none is buried
    u = rng.random(count)
    radii = np.sort((smallest**-2 + u * (largest**-2 - smallest**-2)) ** -0.5)[::-1]
    for radius in radii:
        x, y = rng.uniform(0, width), rng.uniform(0, height)
        left, top = max(int(x - radius), 0), max(int(y - radius), 0)
        part = canvas[top : int(y + radius) + 1, left : int(x + radius) + 1]
        yy, xx = np.mgrid[top : top + part.shape[0], left : left + part.shape[1]]
        inside = (xx - x) ** 2 + (yy - y) ** 2 < radius**2
        grey = rng.beta(1.2, 1.8)
        tint = 1 + 0.35 * rng.standard_normal(camera.channels) * (camera.channels > 1)
        part[inside] = np.clip(grey * tint, 0.01, 1.4)
    grain = ndimage.gaussian_filter(rng.standard_normal((height, width)), 1.5)
    canvas *= 1 + 0.12 * grain[..., None] / grain.std()
    slow = ndimage.gaussian_filter(rng.standard_normal((height, width)), height / 5)
    canvas *= np.exp(0.25 * slow[..., None] / slow.std())
    canvas *= mean * camera.range_dn / canvas.mean()
    return flat_scene(camera, np.clip(canvas, 0, 1.3 * camera.range_dn))


def edges(camera: IdealCamera, rng: np.random.Generator) -> FlatScene:
    """Slanted squares all over the field: straight edges near both image axes."""
    height, width = canvas_shape(camera)
    pitch = height / 4.5
    angle = np.radians(rng.uniform(4, 7))
    y, x = np.mgrid[0:height, 0:width]
    u = (np.cos(angle) * x + np.sin(angle) * y) / pitch
    v = (-np.sin(angle) * x + np.cos(angle) * y) / pitch
    inside = (np.abs(u % 1 - 0.5) < 0.27) & (np.abs(v % 1 - 0.5) < 0.27)
    grey = np.where(inside, 0.12, 0.68) * camera.range_dn
    return flat_scene(camera, np.repeat(grey[..., None], camera.channels, axis=2))


@dataclass(frozen=True, eq=False)
class Chart:
    picture: FlatScene
    boxes: NDArray[np.int64]  # (P, 4) x, y, width, height in the image [px]
    colours: Image  # (P, 3) expected light, above the pedestal [DN]


def chart(camera: IdealCamera, rng: np.random.Generator) -> Chart:
    """Twenty-four patches: random colours, and a row of greys."""
    canvas = np.full((*canvas_shape(camera), camera.channels), 0.25)
    columns, rows = 6, 4
    step_x, step_y = camera.width_px / columns, camera.height_px / rows
    boxes, colours = [], []
    for i in range(columns * rows):
        column, row = i % columns, i // columns
        grey = row == rows - 1
        colour = (
            np.full(3, np.linspace(0.04, 0.85, columns)[column]) if grey else rng.uniform(0.05, 0.85, size=3)
        )
        if camera.channels == 1:
            colour = np.full(3, colour.mean())
        x0, y0 = (column + 0.08) * step_x, (row + 0.08) * step_y
        x1, y1 = (column + 0.92) * step_x, (row + 0.92) * step_y
        area = [
            round((v + MARGIN * size) * OVERSAMPLING)
            for v, size in (
                (y0, camera.height_px),
                (y1, camera.height_px),
                (x0, camera.width_px),
                (x1, camera.width_px),
            )
        ]
        canvas[area[0] : area[1], area[2] : area[3]] = colour[: camera.channels]
        inner = (x0 + 0.15 * step_x, y0 + 0.15 * step_y, 0.54 * step_x, 0.54 * step_y)
        boxes.append([round(v) for v in inner])
        colours.append(colour * camera.range_dn)
    return Chart(flat_scene(camera, canvas * camera.range_dn), np.array(boxes, np.int64), np.array(colours))


@dataclass(frozen=True, eq=False)
class Checkers:
    """A chessboard of which `columns` x `rows` inner corners are seen, on a pale ground."""

    camera: IdealCamera
    rotation: Image  # (3, 3) board to camera
    shift_mm: Image  # (3,) its centre before the camera [mm]
    columns: int = 9
    rows: int = 6
    square_mm: float = 25.0

    def __call__(self, x: Image, y: Image, channel: int) -> Image:
        """The light at pixels, averaged over 5 x 5 rays in each."""
        offsets = (np.arange(5) - 2) / 5
        total = np.zeros(x.shape)
        for dy in offsets:
            for dx in offsets:
                total += self._hit(x + dx, y + dy)
        return total / 25 * self.camera.range_dn

    def _hit(self, x: Image, y: Image) -> Image:
        cx, cy = self.camera.centre_px
        ray = np.stack([(x - cx) / self.camera.focal_px, (y - cy) / self.camera.focal_px, np.ones_like(x)])
        normal = self.rotation[:, 2]
        distance = (normal @ self.shift_mm) / np.tensordot(normal, ray, axes=1)
        on_board = np.tensordot(self.rotation.T, ray * distance - self.shift_mm[:, None, None], axes=1)
        u = on_board[0] / self.square_mm + (self.columns + 1) / 2
        v = on_board[1] / self.square_mm + (self.rows + 1) / 2
        inside = (u > 0) & (u < self.columns + 1) & (v > 0) & (v < self.rows + 1)
        black = (np.floor(u) + np.floor(v)) % 2 == 0
        return np.where(inside & black, 0.08, 0.7)


def board(camera: IdealCamera, rng: np.random.Generator, tilt_deg: float = 30.0) -> Checkers:
    """A board that fills much of the image, tilted about a random axis of its plane."""
    axis = rng.uniform(0, 2 * np.pi)
    tilt = np.radians(rng.uniform(0.6, 1.0) * tilt_deg)
    roll = np.radians(rng.uniform(-12, 12))
    a = np.array([np.cos(axis), np.sin(axis), 0.0])
    cross = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    tilted = np.eye(3) + np.sin(tilt) * cross + (1 - np.cos(tilt)) * cross @ cross
    turned = np.array([[np.cos(roll), -np.sin(roll), 0], [np.sin(roll), np.cos(roll), 0], [0, 0, 1]])
    width_mm = 11 * 25.0
    distance = camera.focal_px * width_mm / (camera.width_px * rng.uniform(0.8, 0.88))
    room = 0.03 * distance
    shift = np.array([rng.uniform(-room, room), rng.uniform(-room, room), distance])
    return Checkers(camera, tilted @ turned, shift)
