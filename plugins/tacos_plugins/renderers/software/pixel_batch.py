"""Pixels that are shaded together: a row for each number that they have, all rows in one run of memory.

A number of pixel `i` stands at the begin of its row plus `i`. Begins are constants, so that compiled loops
know which rows they read and write, and that these do not overlap.
"""

from __future__ import annotations

import numpy as np

CAPACITY = 8192
"""Pixels in a batch: few enough that what one loop writes is in the cache for the next one."""


def _begins(first: int, count: int) -> range:
    return range(first * CAPACITY, (first + count) * CAPACITY, CAPACITY)


# Of floats, first what vertices say (see `surface_attributes`); light is changed in place by what follows.
ATTRIBUTES = 17
U, V, MAP_U, MAP_V, RED, GREEN, BLUE, BEND_U, BEND_V = _begins(0, 9)
NORMAL_X, NORMAL_Y, NORMAL_Z, TANGENT_X, TANGENT_Y, TANGENT_Z, SIDE, SHARE = _begins(9, 8)

# Change of texture coordinates along columns and rows of the image, in place of which come the steps between
# the taps of a texture.
U_X, U_Y, V_X, V_Y = _begins(17, 4)

# The ray of each pixel, of depth 1, and where it ends [m].
RAY_X, RAY_Y, RAY_Z, PLACE_X, PLACE_Y, PLACE_Z = _begins(21, 6)

# Square root of reflectance, tilt of the normal and a channel that is not used, light that is mirrored,
# cosine of the angle of view, and how much two probes count.
TEXEL_RED, TEXEL_GREEN, TEXEL_BLUE, TILT_U, TILT_V, TILT_W = _begins(27, 6)
AROUND_RED, AROUND_GREEN, AROUND_BLUE, FACING, WEIGHT, SECOND_WEIGHT = _begins(33, 6)
_FLOATS = 39

# Of whole numbers: the pixel of the image (or of another batch), layers of texture and normal map, material;
# level and taps of a texture; two probes, and their layer for the roughness.
PIXEL, COLOUR_LAYER, NORMAL_LAYER, MATERIAL, LEVEL, TAPS, PROBE, SECOND_PROBE, ROUGHNESS = _begins(0, 9)
_INTEGERS = 9


class PixelBatch:
    """Memory of a batch: used again for every one."""

    def __init__(self) -> None:
        self.floats = np.zeros(_FLOATS * CAPACITY, np.float32)
        self.integers = np.zeros(_INTEGERS * CAPACITY, np.int32)
