"""What glossy surfaces mirror, for a batch of pixels, as in `reflection.glsl`, where its sources are named.

Loops as in `texture_loops`: without branches, over rows that do not overlap.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_framework.compiled import compiled, inlined, unaliased
from tacos_plugins.renderers.moderngl.pixel_batch import (
    AROUND_BLUE,
    AROUND_GREEN,
    AROUND_RED,
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
_OF_BOX = np.int32(9)  # numbers: centre, lower and upper corner


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

    Parameters
    ----------
    probe_map
        (rows, columns) as `ProbeMap.packed` gives it.
    map_origin
        x and y of its corner [m], and cells per metre.
    materials
        (M, 9) see `ShadingTables`.
    floats, integers
        Rows of a `PixelBatch`.
    count
        Pixels in it.
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


@unaliased
def look_into_probes(
    probes: Floats, boxes: Floats, levels: int, scale: float, floats: Floats, integers: Integers, count: int
) -> None:
    """Luminance that probes show along directions, with the parallax of their boxes.

    Parameters
    ----------
    probes
        (probes * levels, E, E, 3) octahedral luminance with a border [cd/m2].
    boxes
        (probes, 3, 3) place, and lower and upper corner of the room [m].
    levels, scale
        Layers of a probe, and of octahedral coordinates into one.
    floats, integers
        Rows of a `PixelBatch`: directions stand in those of the normal.
    count
        Pixels in it.
    """
    layers, corners, edge = probes.reshape(-1), boxes.reshape(-1), np.int32(probes.shape[1])
    last, half_edge = np.float32(probes.shape[1] - 1), np.float32(probes.shape[1] / 2 - 0.5)
    scaled = np.float32(scale * probes.shape[1])
    for i in range(count):
        x, y, z = floats[NORMAL_X + i], floats[NORMAL_Y + i], floats[NORMAL_Z + i]
        probe, weight = integers[PROBE + i], floats[WEIGHT + i]
        box = _OF_BOX * probe
        from_x, far_x = _to_wall(corners, box, np.int32(0), floats[PLACE_X + i], x)
        from_y, far_y = _to_wall(corners, box, np.int32(1), floats[PLACE_Y + i], y)
        from_z, far_z = _to_wall(corners, box, np.int32(2), floats[PLACE_Z + i], z)
        far = min(far_x, min(far_y, far_z))
        x, y, z = from_x + x * far, from_y + y * far, from_z + z * far
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
def _to_wall(
    corners: Floats, box: np.int32, axis: np.int32, place: np.float32, direction: np.float32
) -> tuple[np.float32, np.float32]:
    """Where a place lies from a probe along an axis, drawn into its box, and how far its wall is that way."""
    lower, upper = corners[np.uint32(box + np.int32(3) + axis)], corners[np.uint32(box + np.int32(6) + axis)]
    inside = min(upper, max(lower, place))
    far = max((lower - inside) / direction, (upper - inside) / direction)
    return inside - corners[np.uint32(box + axis)], far


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
