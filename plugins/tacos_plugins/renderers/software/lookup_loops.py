"""Textures, light maps and probes looked up for a batch of pixels, as `surface.frag` and what it includes do.

Loops without branches over rows that do not overlap, with narrow indices: LLVM takes eight pixels at once,
and fetches their texels together. What becomes an index is bounded by `max(bound, number)`, in this order,
which is the bound where the number is none (NaN).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.compiled.loops import inlined, unaliased
from tacos_plugins.renderers.software.pixel_batch import (
    AROUND_BLUE,
    AROUND_GREEN,
    AROUND_RED,
    BEND_U,
    BEND_V,
    BLUE,
    COLOUR_LAYER,
    GREEN,
    LEVEL,
    MAP_U,
    MAP_V,
    NORMAL_LAYER,
    NORMAL_X,
    NORMAL_Y,
    NORMAL_Z,
    PLACE_X,
    PLACE_Y,
    PLACE_Z,
    PROBE,
    RED,
    ROUGHNESS,
    SHARE,
    TAPS,
    TEXEL_BLUE,
    TEXEL_GREEN,
    TEXEL_RED,
    TILT_U,
    TILT_V,
    TILT_W,
    U_X,
    U_Y,
    V_X,
    V_Y,
    WEIGHT,
    U,
    V,
)

Floats = NDArray[np.float32]
Integers = NDArray[np.int32]

_MOST_TAPS = np.float32(4)  # of MOST_TAPS and BIAS in texture_filter.glsl
_HALF_A_LEVEL_FINER = np.float32(0.5)  # of a squared width
_TOGETHER = 64  # pixels that take as many taps as that of them with the most
_SIXTEEN_BITS = np.float32(1 / (255 * 256))

_ZERO, _HALF, _ONE, _TINY = np.float32(0), np.float32(0.5), np.float32(1), np.float32(1e-20)
_OF_BOX = np.int32(9)  # numbers: centre, lower and upper corner
_NONE, _NEXT, _BYTE, _WHOLE = np.int32(0), np.int32(1), np.int32(8), np.int32(256)
_EVEN_BYTES, _LOW_BYTE, _LOW_BYTES = np.int32(0xFF00FF), np.int32(0xFF), np.int32(0xFFFF)


@unaliased
def colours(
    texels: Integers, offsets: Integers, edge: int, floats: Floats, integers: Integers, count: int
) -> None:
    """Square roots of reflectance: the mean of up to four taps along a pixel's long footprint.

    `texels`, `offsets`, `edge`: see `TexelStack`. `floats`, `integers`: rows of a `PixelBatch` [1].
    """
    squared, last = np.float32(2 * edge * edge), np.int32(len(offsets) - 1)
    for i in range(count):
        u_x, u_y, v_x, v_y = floats[U_X + i], floats[U_Y + i], floats[V_X + i], floats[V_Y + i]
        x2, y2 = u_x * u_x + v_x * v_x, u_y * u_y + v_y * v_y
        longer, area = max(x2, y2), abs(u_x * v_y - u_y * v_x)
        ratio = min(_MOST_TAPS, max(_ONE, longer / max(_TINY, area)))
        integers[LEVEL + i] = _level(_HALF_A_LEVEL_FINER * squared * longer / (ratio * ratio), last)
        taps = np.int32(ratio + _HALF)
        integers[TAPS + i] = taps
        along_u = u_x if x2 > y2 else u_y
        along_v = v_x if x2 > y2 else v_y
        step_u, step_v = along_u / np.float32(taps), along_v / np.float32(taps)
        floats[U_X + i], floats[V_X + i] = step_u, step_v
        floats[U + i] -= _HALF * (along_u - step_u)
        floats[V + i] -= _HALF * (along_v - step_v)
    for begin in range(0, count, _TOGETHER):
        together, some, numbers = min(_TOGETHER, count - begin), floats[begin:], integers[begin:]
        most = _NEXT
        for i in range(together):
            some[TEXEL_RED + i], some[TEXEL_GREEN + i], some[TEXEL_BLUE + i] = _ZERO, _ZERO, _ZERO
            most = max(most, numbers[TAPS + i])
        for tap in range(most):
            _add_tap(texels, offsets, edge, some, numbers, together, tap, COLOUR_LAYER, TEXEL_RED)


@unaliased
def tilts(
    texels: Integers, offsets: Integers, edge: int, floats: Floats, integers: Integers, count: int
) -> None:
    """Tilts of the normal along tangent and bitangent, by a single tap of a normal map."""
    squared, last = np.float32(2 * edge * edge), np.int32(len(offsets) - 1)
    scale, middle = np.float32(255 / 127), np.float32(128 / 127)
    for i in range(count):
        u_x, u_y, v_x, v_y = floats[U_X + i], floats[U_Y + i], floats[V_X + i], floats[V_Y + i]
        integers[LEVEL + i] = _level(squared * max(u_x * u_x + v_x * v_x, u_y * u_y + v_y * v_y), last)
        integers[TAPS + i] = _NEXT
        floats[TILT_U + i], floats[TILT_V + i], floats[TILT_W + i] = _ZERO, _ZERO, _ZERO
    _add_tap(texels, offsets, edge, floats, integers, count, 0, NORMAL_LAYER, TILT_U)
    for i in range(count):
        floats[TILT_U + i] = floats[TILT_U + i] * scale - middle
        floats[TILT_V + i] = floats[TILT_V + i] * scale - middle


@inlined
def _level(twice_squared: np.float32, last: np.int32) -> np.int32:
    """The mipmap level nearest to a footprint, of twice its squared width in texels: half of the exponent."""
    exponent = (np.float32(max(_TINY, twice_squared)).view(np.int32) >> np.int32(23)) - np.int32(127)
    return min(max(exponent >> _NEXT, _NONE), last)


@inlined
def _add_tap(
    texels: Integers,
    offsets: Integers,
    edge: int,
    floats: Floats,
    integers: Integers,
    count: int,
    tap: int,
    layer_row: int,
    into_row: int,
) -> None:
    """Add a tap of a texture that repeats itself to three rows, or nothing where a pixel has fewer taps."""
    number = np.float32(tap)
    for i in range(count):
        level = integers[LEVEL + i]
        size = np.int32(edge) >> level
        u, v = floats[U + i] + floats[U_X + i] * number, floats[V + i] + floats[V_X + i] * number
        x = max(_ZERO, u - np.floor(u)) * np.float32(size) - _HALF
        y = max(_ZERO, v - np.floor(v)) * np.float32(size) - _HALF
        left, top = np.floor(x), np.floor(y)
        across, down = np.int32((x - left) * np.float32(256)), np.int32((y - top) * np.float32(256))
        x0, y0 = np.int32(left), np.int32(top)
        x1, y1 = x0 + _NEXT, y0 + _NEXT
        x0 = x0 + size if x0 < _NONE else x0
        y0 = y0 + size if y0 < _NONE else y0
        x1 = _NONE if x1 >= size else x1
        y1 = _NONE if y1 >= size else y1
        first = offsets[np.uint32(level)] + integers[layer_row + i] * size * size
        above, below = first + y0 * size, first + y1 * size
        a, b = texels[np.uint32(above + x0)], texels[np.uint32(above + x1)]
        c, d = texels[np.uint32(below + x0)], texels[np.uint32(below + x1)]
        of_d = (across * down) >> _BYTE
        of_b, of_c = across - of_d, down - of_d
        of_a = _WHOLE - across - of_c
        # Two bytes at once: sixteen bits hold the sum of four times 255 with weights that add up to 256.
        even = (a & _EVEN_BYTES) * of_a + (b & _EVEN_BYTES) * of_b
        even += (c & _EVEN_BYTES) * of_c + (d & _EVEN_BYTES) * of_d
        odd = ((a >> _BYTE) & _LOW_BYTE) * of_a + ((b >> _BYTE) & _LOW_BYTE) * of_b
        odd += ((c >> _BYTE) & _LOW_BYTE) * of_c + ((d >> _BYTE) & _LOW_BYTE) * of_d
        taps = integers[TAPS + i]
        weight = _SIXTEEN_BITS / np.float32(taps) if np.int32(tap) < taps else _ZERO
        floats[into_row + i] += weight * np.float32(even & _LOW_BYTES)
        floats[into_row + (TEXEL_GREEN - TEXEL_RED) + i] += weight * np.float32(odd)
        floats[into_row + (TEXEL_BLUE - TEXEL_RED) + i] += weight * np.float32(
            (even >> np.int32(16)) & _LOW_BYTES
        )


@unaliased
def light_of_maps(light_map: Floats, bend_map: Floats, floats: Floats, count: int) -> None:
    """Light, its share that shadows leave, and its bend.

    `light_map`, `bend_map`: (rows, columns, 4) and (rows, columns, 2), as in `BakedMesh` [cd/m2, 1].
    `floats`: rows of a `PixelBatch`.
    """
    rows, columns = light_map.shape[0], light_map.shape[1]
    light, bend = light_map.reshape(-1), bend_map.reshape(-1)
    width, rightmost, lowest = np.int32(columns), np.int32(columns - 1), np.int32(rows - 1)
    for i in range(count):
        x = min(np.float32(columns - 1), max(_ZERO, floats[MAP_U + i] * np.float32(columns) - _HALF))
        y = min(np.float32(rows - 1), max(_ZERO, floats[MAP_V + i] * np.float32(rows) - _HALF))
        left, top = np.floor(x), np.floor(y)
        across, down = x - left, y - top
        x0, y0 = np.int32(left), np.int32(top)
        x1, y1 = min(x0 + _NEXT, rightmost), min(y0 + _NEXT, lowest)
        a, b, c, d = y0 * width + x0, y0 * width + x1, y1 * width + x0, y1 * width + x1
        of_d = across * down
        of_b, of_c = across - of_d, down - of_d
        shares = (_ONE - across - of_c, of_b, of_c, of_d)
        texels = (np.int32(4) * a, np.int32(4) * b, np.int32(4) * c, np.int32(4) * d)
        floats[RED + i] = _between(light, texels, np.int32(0), shares)
        floats[GREEN + i] = _between(light, texels, np.int32(1), shares)
        floats[BLUE + i] = _between(light, texels, np.int32(2), shares)
        floats[SHARE + i] = _between(light, texels, np.int32(3), shares)
        texels = (np.int32(2) * a, np.int32(2) * b, np.int32(2) * c, np.int32(2) * d)
        floats[BEND_U + i] = _between(bend, texels, np.int32(0), shares)
        floats[BEND_V + i] = _between(bend, texels, np.int32(1), shares)


@unaliased
def look_into_probes(
    probes: Floats, boxes: Floats, levels: int, scale: float, floats: Floats, integers: Integers, count: int
) -> None:
    """Luminance that probes show along directions, with the parallax of their boxes.

    - `probes`: (probes * levels, E, E, 3) octahedral luminance with a border [cd/m2].
    - `boxes`: (probes, 3, 3) place, and lower and upper corner of the room [m].
    - `levels`, `scale`: layers of a probe, and of octahedral coordinates into one.
    - `floats`, `integers`: rows of a `PixelBatch`: directions stand in those of the normal.
    """
    layers, corners, edge = probes.reshape(-1), boxes.reshape(-1), np.int32(probes.shape[1])
    last, half_edge = np.float32(probes.shape[1] - 1), np.float32(probes.shape[1] / 2 - 0.5)
    scaled = np.float32(scale * probes.shape[1])
    for i in range(count):
        x, y, z = floats[NORMAL_X + i], floats[NORMAL_Y + i], floats[NORMAL_Z + i]
        probe, weight = integers[PROBE + i], floats[WEIGHT + i]
        box = _OF_BOX * probe
        lower_x, upper_x = corners[np.uint32(box + np.int32(3))], corners[np.uint32(box + np.int32(6))]
        lower_y, upper_y = corners[np.uint32(box + np.int32(4))], corners[np.uint32(box + np.int32(7))]
        lower_z, upper_z = corners[np.uint32(box + np.int32(5))], corners[np.uint32(box + np.int32(8))]
        from_x = min(upper_x, max(lower_x, floats[PLACE_X + i]))
        from_y = min(upper_y, max(lower_y, floats[PLACE_Y + i]))
        from_z = min(upper_z, max(lower_z, floats[PLACE_Z + i]))
        far_x = max((lower_x - from_x) / x, (upper_x - from_x) / x)
        far_y = max((lower_y - from_y) / y, (upper_y - from_y) / y)
        far_z = max((lower_z - from_z) / z, (upper_z - from_z) / z)
        far = min(min(far_x, far_y), far_z)
        x = from_x + x * far - corners[np.uint32(box)]
        y = from_y + y * far - corners[np.uint32(box + np.int32(1))]
        z = from_z + z * far - corners[np.uint32(box + np.int32(2))]
        inverse = _ONE / (abs(x) + abs(y) + abs(z))
        x, y = x * inverse, y * inverse
        folded_x = (_ONE - abs(y)) * (_ONE if x >= _ZERO else -_ONE)
        folded_y = (_ONE - abs(x)) * (_ONE if y >= _ZERO else -_ONE)
        column = (x if z >= _ZERO else folded_x) * scaled + half_edge
        row = (y if z >= _ZERO else folded_y) * scaled + half_edge
        column, row = min(last, max(_ZERO, column)), min(last, max(_ZERO, row))
        left, top = np.floor(column), np.floor(row)
        across, down = column - left, row - top
        x0, y0 = np.int32(left), np.int32(top)
        x1, y1 = min(x0 + _NEXT, edge - _NEXT), min(y0 + _NEXT, edge - _NEXT)
        first = (probe * np.int32(levels) + integers[ROUGHNESS + i]) * edge
        above, below = (first + y0) * edge, (first + y1) * edge
        three = np.int32(3)
        texels = (three * (above + x0), three * (above + x1), three * (below + x0), three * (below + x1))
        of_d = weight * across * down
        of_b, of_c = weight * across - of_d, weight * down - of_d
        shares = (weight - weight * across - of_c, of_b, of_c, of_d)
        floats[AROUND_RED + i] = _between(layers, texels, np.int32(0), shares)
        floats[AROUND_GREEN + i] = _between(layers, texels, np.int32(1), shares)
        floats[AROUND_BLUE + i] = _between(layers, texels, np.int32(2), shares)


@inlined
def _between(
    table: Floats,
    texels: tuple[np.int32, np.int32, np.int32, np.int32],
    channel: np.int32,
    shares: tuple[np.float32, np.float32, np.float32, np.float32],
) -> np.float32:
    """The mean of a channel of four texels."""
    return (
        shares[0] * table[np.uint32(texels[0] + channel)]
        + shares[1] * table[np.uint32(texels[1] + channel)]
        + shares[2] * table[np.uint32(texels[2] + channel)]
        + shares[3] * table[np.uint32(texels[3] + channel)]
    )
