"""Background behind all that is drawn."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.compiled.loops import compiled


@compiled
def even(
    ambient_cd_m2: NDArray[np.float32], triangle: NDArray[np.int32], luminance_cd_m2: NDArray[np.float32]
) -> None:
    """Fill in one luminance where (H, W) pixels see no triangle [cd/m2]."""
    red, green, blue = ambient_cd_m2
    for y in range(triangle.shape[0]):
        for x in range(triangle.shape[1]):
            if triangle[y, x] == 0:
                luminance_cd_m2[y, x, 0] = red
                luminance_cd_m2[y, x, 1] = green
                luminance_cd_m2[y, x, 2] = blue


@compiled
def sky(
    sky_cd_m2: NDArray[np.float32],
    rays: NDArray[np.float64],
    triangle: NDArray[np.int32],
    luminance_cd_m2: NDArray[np.float32],
) -> None:
    """Fill in a panorama where (H, W) pixels see no triangle.

    - `sky_cd_m2`: (rows, columns, 3) from the zenith to the nadir, and from +x by way of +y [cd/m2].
    - `rays`: (4, 3) change of a pixel's ray along columns and along rows, ray of pixel (0, 0), and one more
      row.
    - `triangle`, `luminance_cd_m2`: (H, W) what pixels see, and (H, W, 3) to be filled in [cd/m2].
    """
    rows, columns = sky_cd_m2.shape[0], sky_cd_m2.shape[1]
    for y in range(triangle.shape[0]):
        for x in range(triangle.shape[1]):
            if triangle[y, x] != 0:
                continue
            dx = np.float32(rays[0, 0] * x + rays[1, 0] * y + rays[2, 0])
            dy = np.float32(rays[0, 1] * x + rays[1, 1] * y + rays[2, 1])
            dz = np.float32(rays[0, 2] * x + rays[1, 2] * y + rays[2, 2])
            turn = math.atan2(dy, dx) / np.float32(2 * math.pi)
            fall = math.atan2(math.sqrt(dx * dx + dy * dy), dz) / np.float32(math.pi)
            column = (turn - math.floor(turn)) * np.float32(columns) - np.float32(0.5)
            row = min(max(fall * np.float32(rows) - np.float32(0.5), np.float32(0)), np.float32(rows - 1))
            left, top = math.floor(column), math.floor(row)
            across, down = np.float32(column - left), np.float32(row - top)
            x0, x1 = left % columns, (left + 1) % columns
            y0, y1 = top, min(top + 1, rows - 1)
            for channel in range(3):
                above = sky_cd_m2[y0, x0, channel] * (1 - across) + sky_cd_m2[y0, x1, channel] * across
                below = sky_cd_m2[y1, x0, channel] * (1 - across) + sky_cd_m2[y1, x1, channel] * across
                luminance_cd_m2[y, x, channel] = above * (1 - down) + below * down
