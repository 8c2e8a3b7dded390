"""A camera as Mitsuba describes it."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera

_MITSUBA_FROM_CAMERA = np.diag([-1.0, -1.0, 1.0, 1.0])
"""Mitsuba's cameras have x to the left and y up; ours have x to the right and y down."""

_FAR_M = 1e5


def sensor(
    mitsuba: ModuleType, camera: Camera, world_from_camera: NDArray[np.float64], near_m: float
) -> dict[str, Any]:
    """A perspective camera whose film averages evenly over each pixel.

    Mitsuba's film spans 0 to its width, so pixel x of ours is ``x + 0.5`` there; it takes the
    offset of the film's middle from the principal point, as a share of the film.
    """
    width, height = camera.width_px, camera.height_px
    cx, cy = camera.centre_px
    return {
        "type": "perspective",
        "to_world": mitsuba.ScalarTransform4f(world_from_camera @ _MITSUBA_FROM_CAMERA),
        "fov": camera.hfov_deg,
        "fov_axis": "x",
        "principal_point_offset_x": 0.5 - (cx + 0.5) / width,
        "principal_point_offset_y": 0.5 - (cy + 0.5) / height,
        "near_clip": near_m,
        "far_clip": _FAR_M,
        "film": {
            "type": "hdrfilm",
            "width": width,
            "height": height,
            "rfilter": {"type": "box"},
            "sample_border": False,
            "pixel_format": "rgb",
            "component_format": "float32",
        },
    }
