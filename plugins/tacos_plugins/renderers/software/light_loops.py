"""Light that surfaces scatter, mirror and emit, for a batch of pixels, as in `surface.frag` and
`reflection.glsl`.

Loops as in `lookup_loops`: without branches, over rows that do not overlap.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.compiled.loops import compiled, inlined, unaliased
from tacos_plugins.renderers.software.pixel_batch import (
    AROUND_BLUE,
    AROUND_GREEN,
    AROUND_RED,
    BEND_U,
    BEND_V,
    BLUE,
    FACING,
    GREEN,
    MATERIAL,
    NORMAL_X,
    NORMAL_Y,
    NORMAL_Z,
    PIXEL,
    PLACE_X,
    PLACE_Y,
    PLACE_Z,
    PROBE,
    RAY_X,
    RAY_Y,
    RAY_Z,
    RED,
    ROUGHNESS,
    SECOND_PROBE,
    SECOND_WEIGHT,
    SHARE,
    SIDE,
    TANGENT_X,
    TANGENT_Y,
    TANGENT_Z,
    TEXEL_BLUE,
    TEXEL_GREEN,
    TEXEL_RED,
    TILT_U,
    TILT_V,
    WEIGHT,
)

Floats = NDArray[np.float32]
Integers = NDArray[np.int32]

_DIELECTRIC, _MATTE, _HIDDEN = np.float32(0.04), np.float32(0.8), np.float32(0.25)
_OFF_WALL_M = np.float32(0.1)
_LEAST_COSINE, _LEAST_DIRECTION = np.float32(0.02), np.float32(1e-6)

_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_NEXT = np.int32(1)
_OF_MATERIAL = np.int32(9)  # numbers: base colour; roughness, metallic and level; emission


@unaliased
def scatter(floats: Floats, count: int, textured: bool, bumpy: bool) -> None:
    """Light that surfaces scatter: where they are textured, by reflectance; where bumpy, bent by the tilt.

    Light that was extrapolated below zero is none.
    """
    for i in range(count):
        floats[RED + i] = max(_ZERO, floats[RED + i])
        floats[GREEN + i] = max(_ZERO, floats[GREEN + i])
        floats[BLUE + i] = max(_ZERO, floats[BLUE + i])
    if textured:
        for i in range(count):
            floats[RED + i] *= floats[TEXEL_RED + i] * floats[TEXEL_RED + i]
            floats[GREEN + i] *= floats[TEXEL_GREEN + i] * floats[TEXEL_GREEN + i]
            floats[BLUE + i] *= floats[TEXEL_BLUE + i] * floats[TEXEL_BLUE + i]
    else:  # a mirror's tint is asked for all the same
        for i in range(count):
            floats[TEXEL_RED + i], floats[TEXEL_GREEN + i], floats[TEXEL_BLUE + i] = _ONE, _ONE, _ONE
    if bumpy:
        for i in range(count):
            factor = _ONE + floats[TILT_U + i] * floats[BEND_U + i] + floats[TILT_V + i] * floats[BEND_V + i]
            factor = min(np.float32(2), max(_ZERO, factor))
            floats[RED + i] *= factor
            floats[GREEN + i] *= factor
            floats[BLUE + i] *= factor


@unaliased
def tilt_normals(floats: Floats, count: int) -> None:
    """Tilt the normals of a batch along their tangents and bitangents."""
    for i in range(count):
        u, v = floats[TILT_U + i], floats[TILT_V + i] * floats[SIDE + i]
        nx, ny, nz = floats[NORMAL_X + i], floats[NORMAL_Y + i], floats[NORMAL_Z + i]
        tx, ty, tz = floats[TANGENT_X + i], floats[TANGENT_Y + i], floats[TANGENT_Z + i]
        floats[NORMAL_X + i] = nx + u * tx + v * (ny * tz - nz * ty)
        floats[NORMAL_Y + i] = ny + u * ty + v * (nz * tx - nx * tz)
        floats[NORMAL_Z + i] = nz + u * tz + v * (nx * ty - ny * tx)


@unaliased
def mirror_rays(
    probe_map: Floats,
    map_origin: tuple[float, float, float],
    materials: Floats,
    floats: Floats,
    integers: Integers,
    count: int,
) -> None:
    """Turn normals into the directions that are mirrored, and find the probes that are mirrored there.

    - `probe_map`: (rows, columns) as `ProbeMap.packed` gives it.
    - `map_origin`: x and y of its corner [m], and cells per metre.
    - `materials`: (M, 9) see `ShadingTables`.
    - `floats`, `integers`: rows of a `PixelBatch`.
    """
    columns = np.int32(probe_map.shape[1])
    cells, table = probe_map.reshape(-1), materials.reshape(-1)
    origin_x, origin_y = np.float32(map_origin[0]), np.float32(map_origin[1])
    per_m = np.float32(map_origin[2])
    last_row, last_column = np.float32(probe_map.shape[0] - 1), np.float32(probe_map.shape[1] - 1)
    for i in range(count):
        nx, ny, nz = floats[NORMAL_X + i], floats[NORMAL_Y + i], floats[NORMAL_Z + i]
        inverse = _ONE / np.sqrt(nx * nx + ny * ny + nz * nz)
        nx, ny, nz = nx * inverse, ny * inverse, nz * inverse
        rx, ry, rz = floats[RAY_X + i], floats[RAY_Y + i], floats[RAY_Z + i]
        inverse = _ONE / np.sqrt(rx * rx + ry * ry + rz * rz)
        rx, ry, rz = rx * inverse, ry * inverse, rz * inverse
        along = nx * rx + ny * ry + nz * rz
        floats[FACING + i] = min(_ONE, max(_LEAST_COSINE, -along))
        x = (floats[PLACE_X + i] + _OFF_WALL_M * nx - origin_x) * per_m
        y = (floats[PLACE_Y + i] + _OFF_WALL_M * ny - origin_y) * per_m
        column, row = np.int32(min(last_column, max(_ZERO, x))), np.int32(min(last_row, max(_ZERO, y)))
        packed = np.int32(cells[np.uint32(row * columns + column)])
        share = np.float32(packed >> np.int32(10)) * np.float32(1 / 1023)
        floats[WEIGHT + i], floats[SECOND_WEIGHT + i] = _ONE - share, share
        integers[PROBE + i] = packed & np.int32(31)
        integers[SECOND_PROBE + i] = (packed >> np.int32(5)) & np.int32(31)
        integers[ROUGHNESS + i] = np.int32(
            table[np.uint32(_OF_MATERIAL * integers[MATERIAL + i] + np.int32(5))]
        )
        dx, dy, dz = rx - (along + along) * nx, ry - (along + along) * ny, rz - (along + along) * nz
        floats[NORMAL_X + i] = dx if abs(dx) > _LEAST_DIRECTION else _LEAST_DIRECTION
        floats[NORMAL_Y + i] = dy if abs(dy) > _LEAST_DIRECTION else _LEAST_DIRECTION
        floats[NORMAL_Z + i] = dz if abs(dz) > _LEAST_DIRECTION else _LEAST_DIRECTION


@compiled
def between_two(floats: Floats, integers: Integers, count: int, into: Floats, numbers: Integers) -> int:
    """Copy to another batch what a second probe is looked into by; how many pixels mirror one."""
    found = 0
    for i in range(count):
        if floats[SECOND_WEIGHT + i] > _ZERO:
            for row in (PLACE_X, PLACE_Y, PLACE_Z, NORMAL_X, NORMAL_Y, NORMAL_Z):
                into[row + found] = floats[row + i]
            into[WEIGHT + found] = floats[SECOND_WEIGHT + i]
            numbers[PROBE + found] = integers[SECOND_PROBE + i]
            numbers[ROUGHNESS + found] = integers[ROUGHNESS + i]
            numbers[PIXEL + found] = i
            found += 1
    return found


@compiled
def add_second(floats: Floats, found: Floats, numbers: Integers, count: int) -> None:
    """Add what a second probe shows to the pixels of the batch that mirror one."""
    for row in (AROUND_RED, AROUND_GREEN, AROUND_BLUE):
        for i in range(count):
            floats[row + numbers[PIXEL + i]] += found[row + i]


@unaliased
def reflect(materials: Floats, floats: Floats, integers: Integers, count: int) -> None:
    """Add what is mirrored and emitted to the light that gets beneath the coat and is scattered there."""
    table = materials.reshape(-1)
    for i in range(count):
        kind = _OF_MATERIAL * integers[MATERIAL + i]
        roughness, metallic = table[np.uint32(kind + np.int32(3))], table[np.uint32(kind + np.int32(4))]
        # How much a rough mirror returns at this angle (Karis, "Physically based shading on mobile", 2014).
        smooth = _ONE - roughness
        falling = min(smooth * smooth, _power_of_two(np.float32(-9.28) * floats[FACING + i])) * smooth
        falling += np.float32(0.0425) - np.float32(0.0275) * roughness
        scale = np.float32(1.04) - np.float32(0.572) * roughness - np.float32(1.04) * falling
        bias = np.float32(0.022) * roughness - np.float32(0.04) + np.float32(1.04) * falling
        sheen = min(_ONE, max(_ZERO, (_MATTE - roughness) / np.float32(0.4)))
        plain, bias = _DIELECTRIC * sheen * (_ONE - metallic), max(sheen, metallic) * bias
        lit = _HIDDEN + (_ONE - _HIDDEN) * min(_ONE, max(_ZERO, floats[SHARE + i]))
        texel, around = floats[TEXEL_RED + i], floats[AROUND_RED + i]
        returned = (plain + metallic * table[np.uint32(kind)] * texel * texel) * scale + bias
        glow = table[np.uint32(kind + np.int32(6))]
        floats[RED + i] = floats[RED + i] * (_ONE - returned) + returned * around * lit + glow
        texel, around = floats[TEXEL_GREEN + i], floats[AROUND_GREEN + i]
        returned = (plain + metallic * table[np.uint32(kind + _NEXT)] * texel * texel) * scale + bias
        glow = table[np.uint32(kind + np.int32(7))]
        floats[GREEN + i] = floats[GREEN + i] * (_ONE - returned) + returned * around * lit + glow
        texel, around = floats[TEXEL_BLUE + i], floats[AROUND_BLUE + i]
        returned = (plain + metallic * table[np.uint32(kind + np.int32(2))] * texel * texel) * scale + bias
        glow = table[np.uint32(kind + np.int32(8))]
        floats[BLUE + i] = floats[BLUE + i] * (_ONE - returned) + returned * around * lit + glow


@inlined
def _power_of_two(power: np.float32) -> np.float32:
    """2 to a power: its whole part as an exponent, the rest by a polynomial within 3e-7."""
    whole = np.floor(power)
    rest = power - whole
    grown = np.float32(8.9893397e-3) + rest * np.float32(1.8775767e-3)
    grown = np.float32(2.4015361e-1) + rest * (np.float32(5.5826318e-2) + rest * grown)
    grown = np.float32(9.9999994e-1) + rest * (np.float32(6.9315308e-1) + rest * grown)
    return grown * np.int32((np.int32(whole) + np.int32(127)) << np.int32(23)).view(np.float32)
