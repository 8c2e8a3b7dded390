"""Triangles seen by pixels, as runs along rows, and attributes between their corners.

In homogeneous pixels, what is linear on a triangle is, over depth, linear in the image: three numbers tell it
of every pixel, also where corners lie behind the camera (Olano and Greer, "Triangle scan conversion using 2D
homogeneous coordinates", Graphics Hardware 1997).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.compiled.loops import compiled
from tacos_plugins.renderers.software.pixel_batch import (
    BLUE,
    CAPACITY,
    COLOUR_LAYER,
    GREEN,
    MATERIAL,
    NORMAL_LAYER,
    PIXEL,
    PLACE_X,
    RAY_X,
    RED,
    U_X,
)

# Columns of a run.
TRIANGLE, SLOT, ROW, COLUMN, LENGTH = range(5)


def runs_by_kind(
    triangle: NDArray[np.int32], kind_of_triangle: NDArray[np.int32], kinds: int
) -> tuple[NDArray[np.int32], NDArray[np.int64], NDArray[np.int32]]:
    """The runs of pixels that see one triangle, those of a kind together.

    - `triangle`: (H, W) number of the triangle that each pixel sees, 0 for none.
    - `kind_of_triangle`: (T + 1,) kind of each, from 0.
    - `kinds`: how many there are.

    Returns:

    - `runs`: (R, 5) int32: triangle, its place in `seen`, row, first column, pixels.
    - `first`: (kinds + 1,) first run of each kind.
    - `seen`: (S,) int32 the triangles seen.
    """
    slot, seen = np.full(len(kind_of_triangle), -1, np.int32), np.empty(len(kind_of_triangle), np.int32)
    first = np.zeros(kinds + 1, np.int64)
    slots = _count_runs(triangle, kind_of_triangle, slot, seen, first)
    runs = np.empty((first[-1], 5), np.int32)
    _fill_runs(triangle, kind_of_triangle, slot, first[:-1].copy(), runs)
    return runs, first, seen[:slots]


@compiled
def _count_runs(
    triangle: NDArray[np.int32],
    kind_of_triangle: NDArray[np.int32],
    slot: NDArray[np.int32],
    seen: NDArray[np.int32],
    first: NDArray[np.int64],
) -> int:
    """Fill in which triangles are seen, their places, and the first run of each kind; how many they are."""
    slots = 0
    for y in range(triangle.shape[0]):
        before = np.int32(0)
        for x in range(triangle.shape[1]):
            number = triangle[y, x]
            if number != before:
                before = number
                if number:
                    first[kind_of_triangle[number] + 1] += 1
                    if slot[number] < 0:
                        slot[number] = slots
                        seen[slots] = number
                        slots += 1
    for kind in range(len(first) - 1):
        first[kind + 1] += first[kind]
    return slots


@compiled
def _fill_runs(
    triangle: NDArray[np.int32],
    kind_of_triangle: NDArray[np.int32],
    slot: NDArray[np.int32],
    place: NDArray[np.int64],
    runs: NDArray[np.int32],
) -> None:
    """Fill in the runs, those of a kind from its place on."""
    width = triangle.shape[1]
    for y in range(triangle.shape[0]):
        x = 0
        while x < width:
            number, start = triangle[y, x], x
            x += 1
            while x < width and triangle[y, x] == number:
                x += 1
            if number:
                kind = kind_of_triangle[number]
                run = place[kind]
                place[kind] += 1
                runs[run, TRIANGLE], runs[run, SLOT], runs[run, ROW] = number, slot[number], y
                runs[run, COLUMN], runs[run, LENGTH] = start, x - start


@compiled
def planes(
    seen: NDArray[np.int32],
    triangles: NDArray[np.int32],
    position_m: NDArray[np.float32],
    attributes: NDArray[np.float32],
    mover_of_triangle: NDArray[np.int32],
    pixel_from_world: NDArray[np.float64],
    found: NDArray[np.float64],
) -> None:
    """Attributes of triangles over depth, as planes above the image.

    - `seen`: (S,) numbers of triangles, from 1.
    - `triangles`, `position_m`, `attributes`: (T, 3), (V, 3) and (V, A): vertices, their places [m] and what
      they say.
    - `mover_of_triangle`: (T + 1,) which of the views is that of the triangle.
    - `pixel_from_world`: (M, 3, 4) of each thing that moves, and of all that rests [px m, m].
    - `found`: (S, A + 1, 5) is filled: change along columns and rows, and level at pixel (0, 0), each over
      depth; least and most, at a corner. The last is 1 over depth.
    """
    count = attributes.shape[1]
    corner = np.empty((3, 3))
    for slot in range(len(seen)):
        number = seen[slot]
        view = mover_of_triangle[number]
        for each in range(3):
            vertex = triangles[number - 1, each]
            x, y, z = position_m[vertex, 0], position_m[vertex, 1], position_m[vertex, 2]
            for axis in range(3):
                corner[each, axis] = (
                    pixel_from_world[view, axis, 0] * x
                    + pixel_from_world[view, axis, 1] * y
                    + pixel_from_world[view, axis, 2] * z
                    + pixel_from_world[view, axis, 3]
                )
        ax, ay, aw = corner[0, 0], corner[0, 1], corner[0, 2]
        bx, by, bw = corner[1, 0], corner[1, 1], corner[1, 2]
        cx, cy, cw = corner[2, 0], corner[2, 1], corner[2, 2]
        # Columns of the inverse of the corners, that is edges of the triangle.
        ex, ey, ew = by * cw - bw * cy, bw * cx - bx * cw, bx * cy - by * cx
        fx, fy, fw = cy * aw - cw * ay, cw * ax - cx * aw, cx * ay - cy * ax
        gx, gy, gw = ay * bw - aw * by, aw * bx - ax * bw, ax * by - ay * bx
        inverse = 1 / (ax * ex + ay * ey + aw * ew)
        ex, ey, ew = ex * inverse, ey * inverse, ew * inverse
        fx, fy, fw = fx * inverse, fy * inverse, fw * inverse
        gx, gy, gw = gx * inverse, gy * inverse, gw * inverse
        first, second, third = triangles[number - 1]
        for each in range(count):
            a, b, c = attributes[first, each], attributes[second, each], attributes[third, each]
            found[slot, each, 0] = a * ex + b * fx + c * gx
            found[slot, each, 1] = a * ey + b * fy + c * gy
            found[slot, each, 2] = a * ew + b * fw + c * gw
            found[slot, each, 3], found[slot, each, 4] = min(a, b, c), max(a, b, c)
        found[slot, count, 0] = ex + fx + gx
        found[slot, count, 1] = ey + fy + gy
        found[slot, count, 2] = ew + fw + gw


@compiled
def interpolate(
    runs: NDArray[np.int32],
    begin: tuple[int, int],
    planes: NDArray[np.float64],
    rows: NDArray[np.int64],
    wanted: tuple[bool, bool],
    depth_m: NDArray[np.float32],
    rays: NDArray[np.float64],
    mover_of_triangle: NDArray[np.int32],
    flat: NDArray[np.int32],
    floats: NDArray[np.float32],
    integers: NDArray[np.int32],
) -> tuple[int, tuple[int, int]]:
    """Fill a batch with what runs say at each of their pixels.

    - `runs`, `begin`: (R, 5) the runs of a kind; the first that is not in a batch yet, and how many of its
      pixels are.
    - `planes`, `rows`: as `planes` gives them, and the rows of the batch that get an attribute.
    - `wanted`: whether changes of texture coordinates are, and whether rays and places.
    - `depth_m`: (H, W) depth of what each pixel sees [m].
    - `rays`: (M, 4, 3) of each view: change of a pixel's ray along columns and along rows, ray of pixel (0,
      0), all of depth 1, and the optical centre [m].
    - `mover_of_triangle`, `flat`: (T + 1,) which of the views is that of a triangle; (T + 1, 3) its layers of
      texture and normal map, and its material.
    - `floats`, `integers`: rows of a `PixelBatch`, to be filled.

    Returns:

    - `count`, `next`: how many pixels the batch has, and where the next one begins.
    """
    width = depth_m.shape[1]
    over_depth = planes.shape[1] - 1
    gradients, places = wanted
    run, done = begin
    at = 0
    while run < len(runs) and at < CAPACITY:
        number, slot, y = runs[run, TRIANGLE], runs[run, SLOT], runs[run, ROW]
        x, count = runs[run, COLUMN] + done, min(runs[run, LENGTH] - done, CAPACITY - at)
        depths, some, numbers = depth_m[y, x:], floats[at:], integers[at:]
        for row in rows:
            plane = row // CAPACITY
            step_x, step_y, level = planes[slot, plane, 0], planes[slot, plane, 1], planes[slot, plane, 2]
            start, step = np.float32(step_x * x + step_y * y + level), np.float32(step_x)
            # Pixels lie within a triangle but for rounding, which slivers make much of.
            least, most = np.float32(planes[slot, plane, 3]), np.float32(planes[slot, plane, 4])
            for i in range(count):
                value = (start + step * np.float32(np.int32(i))) * depths[i]
                some[row + i] = min(most, max(least, value))
        if gradients:
            along, down = np.float32(planes[slot, over_depth, 0]), np.float32(planes[slot, over_depth, 1])
            for axis in range(2):
                step_x, step_y = np.float32(planes[slot, axis, 0]), np.float32(planes[slot, axis, 1])
                value, change = axis * CAPACITY, U_X + 2 * axis * CAPACITY
                for i in range(count):
                    some[change + i] = (step_x - some[value + i] * along) * depths[i]
                    some[change + CAPACITY + i] = (step_y - some[value + i] * down) * depths[i]
        if places:
            view = mover_of_triangle[number]
            for axis in range(3):
                step = np.float32(rays[view, 0, axis])
                start = np.float32(rays[view, 0, axis] * x + rays[view, 1, axis] * y + rays[view, 2, axis])
                eye, row = np.float32(rays[view, 3, axis]), axis * CAPACITY
                for i in range(count):
                    ray = start + step * np.float32(np.int32(i))
                    some[RAY_X + row + i] = ray
                    some[PLACE_X + row + i] = eye + ray * depths[i]
        for i in range(count):
            numbers[PIXEL + i] = y * width + x + i
            numbers[COLOUR_LAYER + i] = flat[number, 0]
            numbers[NORMAL_LAYER + i] = flat[number, 1]
            numbers[MATERIAL + i] = flat[number, 2]
        at, done = at + count, done + count
        if done == runs[run, LENGTH]:
            run, done = run + 1, 0
    return at, (run, done)


@compiled
def put(
    pixels: NDArray[np.float32], floats: NDArray[np.float32], integers: NDArray[np.int32], count: int
) -> None:
    """Store the light of a batch in (pixels, 3) of an image."""
    for i in range(count):
        pixel = np.uint64(integers[PIXEL + i])
        pixels[pixel, 0] = floats[RED + i]
        pixels[pixel, 1] = floats[GREEN + i]
        pixels[pixel, 2] = floats[BLUE + i]
