"""From the frame of a camera to OpenGL's clip space."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera


def projection_matrix(camera: Camera, near_m: float, far_m: float) -> NDArray[np.float64]:
    """OpenGL's projection matrix of a pinhole camera with any principal point.

    It takes points of the OpenCV camera frame to clip space such that the image's first row is the
    framebuffer's first row: what is read back needs no flip. Windings appear mirrored for that reason.

    `near_m`, `far_m`: nearest and farthest depth kept, ``0 < near < far`` [m].

    Returns: (4, 4) float64, to be multiplied from the left to column vectors.

    >>> camera = Camera("c", width_px=4, height_px=2, pixel_um=10, focal_length_mm=0.02)
    >>> clip = projection_matrix(camera, 0.1, 10.0) @ [-2.0, -1.0, 2.0, 1.0]  # the image's first corner
    >>> (clip / clip[3])[:2].tolist()
    [-1.0, -1.0]
    """
    if not 0 < near_m < far_m:
        raise ValueError(f"depth range must rise from above 0, not {near_m} .. {far_m} m")
    if not camera.lens.is_pinhole:
        raise ValueError(
            f"OpenGL draws pinholes, not a {camera.lens.projection} lens: call the renderer by "
            f"tacos_framework.formation.captured"
        )
    cx, cy = camera.centre_px
    width, height, f = camera.width_px, camera.height_px, camera.focal_length_px
    # The image spans -0.5 .. size - 0.5, so ndc = 2 (pixel + 0.5) / size - 1.
    return np.array(
        [
            [2 * f / width, 0.0, (2 * cx + 1) / width - 1, 0.0],
            [0.0, 2 * f / height, (2 * cy + 1) / height - 1, 0.0],
            [0.0, 0.0, (far_m + near_m) / (far_m - near_m), -2 * far_m * near_m / (far_m - near_m)],
            [0.0, 0.0, 1.0, 0.0],
        ]
    )
