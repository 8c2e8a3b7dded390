"""Smaller images, as a device makes them before a task sees them: each pixel the mean of what it covers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator
from scipy.sparse import csr_array

from tacos_framework import Camera, FrameBatch, Settings, View, setting


class Resize:
    """Averages images by area to fewer pixels; what tasks know of their geometry follows.

    A new pixel is the mean of the area that it covers, parts of pixels by their share, so that independent
    noise falls as the root of the area. Pixels stay square: what is left over at the edges, less than one new
    pixel, is dropped evenly. Depth and ids are those at the centre of each new pixel. To tasks the new pixels
    are the camera's own (`Camera.sensor_binning`).

    Source: The mean over areas is OpenCV's ``INTER_AREA``, which it equals for whole factors.
    """

    class Config(Settings):
        """Settings of the transform; of the two exactly one."""

        factor: float | None = setting(
            None, help="Share of each side of the images that is left.", gt=0, le=1, also=("scale",)
        )
        width_px: int | None = setting(
            None,
            help="Width of the camera's images afterwards; of blocks of pixels simulated as one there are "
            "fewer. Narrower images stay as they are.",
            unit="px",
            ge=1,
            also=("width", "size"),
        )

        @model_validator(mode="after")
        def _one_of_two(self) -> Resize.Config:
            if (self.factor is None) == (self.width_px is None):
                found = "neither" if self.factor is None else "both"
                raise ValueError(f"give exactly one of factor and width_px, not {found}")
            return self

    def __init__(self, config: Config) -> None:
        self.config = config

    def transform(self, frames: FrameBatch) -> FrameBatch:
        """The frames in fewer pixels, with the capture as those see it."""
        sizes = [self._pixels(view.camera) for view in frames.capture.views]
        views = [_resized_view(view, size) for view, size in zip(frames.capture.views, sizes, strict=True)]
        images: list[Any] = [
            averaged(image, *_shape(view.camera, size), size).round().astype(image.dtype)
            for image, view, size in zip(frames.images, frames.capture.views, sizes, strict=True)
        ]
        capture = replace(frames.capture, views=tuple(views))
        return replace(frames, capture=capture, images=tuple(images))

    def _pixels(self, camera: Camera) -> float:
        """Pixels of an image along each side of one afterwards [1]."""
        if self.config.factor is not None:
            return 1 / self.config.factor
        assert self.config.width_px is not None, "one of the two is given"
        return max(1.0, camera.width_px * camera.simulated_binning / self.config.width_px)


def averaged(
    images: NDArray[np.generic], height_px: int, width_px: int, pixels: float
) -> NDArray[np.float32]:
    """The mean of images over areas of `pixels` x `pixels` about their middle.

    `images`: (N, H, W, C) samples. `height_px`, `width_px`: size of the result, which the areas cover inside
    the images [px].

    Returns: (N, height_px, width_px, C) float32.

    >>> ramp = np.arange(6.0).reshape(1, 1, 6, 1)
    >>> averaged(np.tile(ramp, (1, 6, 1, 1)), 4, 4, pixels=1.5)[0, 0, :, 0].astype(float).round(3).tolist()
    [0.333, 1.667, 3.333, 4.667]
    """
    _, height, width, channels = images.shape
    rows, columns = _shares(height, height_px, pixels), _shares(width, width_px, pixels)
    means = np.empty((len(images), height_px, width_px, channels), np.float32)
    for image, mean in zip(images, means, strict=True):
        upright = rows @ image.astype(np.float32).reshape(height, -1)
        across = upright.reshape(height_px, width, channels).swapaxes(0, 1).reshape(width, -1)
        mean[...] = (columns @ across).reshape(width_px, height_px, channels).swapaxes(0, 1)
    return means


def _shares(size_px: int, new_px: int, pixels: float) -> csr_array:
    """(new, old) the share that each old pixel of a line has in each new one."""
    edges = (size_px - new_px * pixels) / 2 + pixels * np.arange(new_px + 1)
    old = np.arange(size_px)
    overlap = np.minimum(edges[1:, None], old + 1) - np.maximum(edges[:-1, None], old)
    return csr_array((np.clip(overlap, 0, None) / pixels).astype(np.float32))


def _shape(camera: Camera, pixels: float) -> tuple[int, int]:
    """Height and width of an image afterwards [px]."""
    height, width = (max(1, int(size / pixels + 1e-9)) for size in (camera.height_px, camera.width_px))
    return height, width


def resized_camera(camera: Camera, pixels: float) -> Camera:
    """The camera whose pixels are those afterwards: the same lens, larger pixels of its own."""
    height_px, width_px = _shape(camera, pixels)
    centre = [
        (at + 0.5 - (size - new * pixels) / 2) / pixels - 0.5
        for at, size, new in zip(
            camera.centre_px, (camera.width_px, camera.height_px), (width_px, height_px), strict=True
        )
    ]
    return replace(
        camera,
        width_px=width_px,
        height_px=height_px,
        binning=camera.binning * pixels,
        sensor_binning=camera.sensor_binning * pixels,
        principal_point_px=camera.principal_point_px and (centre[0], centre[1]),
    )


def _resized_view(view: View, pixels: float) -> View:
    """View of the larger pixels: mean light, and the truth at their centres."""
    height_px, width_px = shape = _shape(view.camera, pixels)
    at_centre = np.ix_(
        np.arange(len(view.depth_m)),
        _centres(view.camera.height_px, height_px, pixels),
        _centres(view.camera.width_px, width_px, pixels),
    )
    return replace(
        view,
        camera=resized_camera(view.camera, pixels),
        luminance_cd_m2=averaged(view.luminance_cd_m2, *shape, pixels),
        depth_m=view.depth_m[at_centre],
        object_id=view.object_id[at_centre],
    )


def _centres(size_px: int, new_px: int, pixels: float) -> NDArray[np.intp]:
    """(new,) the old pixel in which the centre of each new one lies."""
    return ((size_px - new_px * pixels) / 2 + pixels * (np.arange(new_px) + 0.5)).astype(np.intp)
