"""Pictures drawn in finer pixels than the camera's, and averaged: edges lie where they should.

The rasteriser places an edge to half a pixel where it runs along rows or columns, and corners of a board
before a fisheye with it: by .11 to .17 px (rms), by .06 to .11 px in fine pictures.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, Capture, Rig, View

FINER = 3
"""Pixels drawn across one of the image; odd, so that one lies in its middle."""


def drawn_finer(take: Callable[..., Capture], *, rig: Rig) -> Capture:
    """A capture of a rig from pictures `FINER` times as fine: mean light, depth and ids of the middles.

    `take`: a renderer's `capture`, all given but the ``rig``.
    """
    fine = take(rig=Rig(tuple(map(finer, rig.cameras))))
    views = (_averaged(view, camera) for view, camera in zip(fine.views, rig.cameras, strict=True))
    return replace(fine, views=tuple(views))


def finer(camera: Camera) -> Camera:
    """A camera at the same place that sees the same in finer pixels.

    >>> camera = finer(Camera("c", 640, 480, pixel_um=3.0, focal_length_mm=3.0))
    >>> camera.width_px, camera.centre_px, camera.pixel_um
    (1920, (959.5, 719.5), 1.0)
    """
    x, y = camera.centre_px
    return replace(
        camera,
        width_px=camera.width_px * FINER,
        height_px=camera.height_px * FINER,
        pixel_um=camera.pixel_um / FINER,
        principal_point_px=((x + 0.5) * FINER - 0.5, (y + 0.5) * FINER - 0.5),
    )


def _averaged(fine: View, camera: Camera) -> View:
    size = camera.height_px, camera.width_px
    light = np.stack([_mean(each, size) for each in fine.luminance_cd_m2])
    middles = np.s_[:, FINER // 2 :: FINER, FINER // 2 :: FINER]
    return replace(
        fine,
        camera=camera,
        luminance_cd_m2=light,
        depth_m=fine.depth_m[middles],
        object_id=fine.object_id[middles],
    )


def _mean(light: NDArray[np.float32], size: tuple[int, int]) -> NDArray[np.float32]:
    height, width = size
    return light.reshape(height, FINER, width, FINER, -1).mean(axis=(1, 3))
