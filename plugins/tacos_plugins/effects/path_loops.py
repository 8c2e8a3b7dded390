"""The loops over pixels of `effect.motion`: what moved to where, and light averaged along its paths."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.compiled.loops import inlined, unaliased

KERNEL_PX = 2
"""Reach of the kernel of the interpolation [px]."""

PHASES = 128
"""Places between two pixels at which the kernel is kept."""

LANES = 24
"""Values that are averaged at once: so many that LLVM makes wide instructions of them."""

MOST_AT_ONCE_PX = 8
"""Most neighbours in a row that one path may serve, moved along with them [px]."""

_SHORTEST_PX = np.float32(1 / 64)
"""Shorter paths are taken as this long: the average is then the value at a point."""

_ROUNDS = 3
"""Looks for the surface that a pixel shows at its row's moment; it lies a readout's motion away."""

Floats = NDArray[np.float32]
Ints = NDArray[np.int32]
Single = Any
"""A number of single precision, as numba makes of all that such numbers are made of."""


@inlined
def _between_rows(table: Floats, row: int, share: Single, out: Floats) -> None:
    """Fill (tables, columns, powers, figures) with a table between two rows of its nodes."""
    for t in range(out.shape[0]):
        for c in range(out.shape[1]):
            for p in range(out.shape[2]):
                for k in range(out.shape[3]):
                    above = table[t, row, c, p, k]
                    out[t, c, p, k] = above + share * (table[t, row + 1, c, p, k] - above)


@inlined
def _value(nodes: Floats, table: int, column: int, share: Single, near: Single, k: int) -> Single:
    """One figure of a table at a place between two nodes, for an inverse depth."""
    left = nodes[table, column, 0, k] + near * (
        nodes[table, column, 1, k] + near * nodes[table, column, 2, k]
    )
    right = nodes[table, column + 1, 0, k] + near * (
        nodes[table, column + 1, 1, k] + near * nodes[table, column + 1, 2, k]
    )
    return left + share * (right - left)


@inlined
def _alike(near: Floats, table_of: Ints, row: int, column: int, most: int, alike: Single) -> int:
    """Number of pixels from one on that have its table, and inverse depths that differ by no more than
    `alike`.
    """
    n, t, count = near[row, column], table_of[row, column], 1
    while count < most and table_of[row, column + count] == t and abs(near[row, column + count] - n) <= alike:
        count += 1
    return count


@unaliased
def find_shown(
    near: Floats,
    table_of: Ints,
    object_id: Ints,
    middle: Floats,
    spacing: int,
    widest: int,
    alike: Single,
    nodes: Floats,
    shown_near: Floats,
    shown_table: Ints,
    depth_m: Floats,
    shown_id: Ints,
) -> None:
    """Fill in the thing that each pixel shows at the moment of its row, and its depth then.

    - `near`, `table_of`, `object_id`: (H, W) inverse depth [1/m], number of the table and object of what the
      frame shows.
    - `middle`: (tables, rows, columns, 3, 3) displacement along x and y [px] and inverse depth [1/m] at every
      `spacing` pixels, as polynomials of the inverse depth in the frame.
    - `widest`, `alike`: as in `average_along`.
    - `nodes`: (tables, columns, 3, 3) is used.
    - `shown_near`, `shown_table`, `depth_m`, `shown_id`: (H, W) are filled: inverse depth in the frame and
      table of what is shown, its depth then [m], and its object.
    """
    height, width = near.shape
    half = np.float32(0.5)
    for y in range(height):
        _between_rows(middle, y // spacing, np.float32(y % spacing) / np.float32(spacing), nodes)
        x = 0
        while x < width:
            node = x // spacing
            share = np.float32(x - node * spacing) / np.float32(spacing)
            at_x, at_y = x, y
            for _ in range(_ROUNDS):
                n, t = near[at_y, at_x], table_of[at_y, at_x]
                to_x = int(np.floor(np.float32(x) + half + _value(nodes, t, node, share, n, 0)))
                to_y = int(np.floor(np.float32(y) + half + _value(nodes, t, node, share, n, 1)))
                to_x, to_y = min(max(to_x, 0), width - 1), min(max(to_y, 0), height - 1)
                if to_x == at_x and to_y == at_y:
                    break
                at_x, at_y = to_x, to_y
            most = min(widest, width - x, width - at_x)
            count = _alike(near, table_of, at_y, at_x, most, alike)
            n, t = near[at_y, at_x], table_of[at_y, at_x]
            then = _value(nodes, t, node, share, n, 2)
            farther = n / then if n > 0 else np.float32(1)
            for k in range(count):
                shown_near[y, x + k] = near[at_y, at_x + k]
                depth_m[y, x + k] = farther / near[at_y, at_x + k]
                shown_table[y, x + k] = t
                shown_id[y, x + k] = object_id[at_y, at_x + k]
            x += count


@inlined
def _kernel_up_to(t: Single, shares: Floats) -> None:
    """Shares of the cubic kernel (Keys 1981) below t + 1, t, t - 1 and t - 2, for t from 0 to 1."""
    half, sixth, eighth = np.float32(0.5), np.float32(1 / 6), np.float32(0.125)
    s = np.float32(1) - t
    shares[0] = np.float32(1) - s * s * s * (eighth * s - sixth)
    shares[1] = half + t * (np.float32(1) + t * t * (np.float32(0.375) * t - np.float32(5 / 6)))
    shares[2] = half - s * (np.float32(1) + s * s * (np.float32(0.375) * s - np.float32(5 / 6)))
    shares[3] = t * t * t * (eighth * t - sixth)


@inlined
def _average(
    lights: Floats,
    origin: int,
    u: Single,
    v: Single,
    along: Single,
    slope: Single,
    step_u: int,
    step_v: int,
    taps: Floats,
    scratch: Floats,
    least: Single,
    most: Single,
    out: Floats,
    target: int,
) -> None:
    """Fill `LANES` values of `out` from `target` on, with as many averages along one line.

    - `lights`, `origin`: (N,) an image row by row, and which of its values the line of the first starts from;
      those of the others follow it.
    - `u`, `v`: the middle of the line along the axis that it mostly follows, and across, from there [px].
    - `along`, `slope`: its length along the axis [px], and how far it goes aside over that [1].
    - `step_u`, `step_v`: from pixel to pixel along the axis and across, in values.
    - `taps`: (PHASES + 1, 4) the kernel.
    - `scratch`: (2, 4) is used.
    - `least`, `most`: what no average lies beyond.
    """
    half = np.float32(0.5)
    begins, ends = scratch[0], scratch[1]
    length: Single = max(abs(along), _SHORTEST_PX)
    low, high = u - half * length, u + half * length
    first, last = int(np.floor(low)) - 1, int(np.floor(high)) - 1
    _kernel_up_to(low - np.float32(first + 1), begins)
    _kernel_up_to(high - np.float32(last + 1), ends)
    scale = np.float32(1) / length
    there = v + (np.float32(first) - u) * slope
    found = out[target : target + LANES]
    for lane in range(LANES):
        found[lane] = 0
    for i in range(first, last + 4):
        weight = np.float32(1) if i < last else ends[i - last]
        if i < first + 4:
            weight -= begins[i - first]
        weight *= scale
        below = np.floor(there)
        phase = int((there - below) * np.float32(PHASES) + half)
        a = np.uint64(origin + i * step_u + (int(below) - 1) * step_v)
        b = a + np.uint64(step_v)
        c = b + np.uint64(step_v)
        d = c + np.uint64(step_v)
        wa, wb = weight * taps[np.uint64(phase), 0], weight * taps[np.uint64(phase), 1]
        wc, wd = weight * taps[np.uint64(phase), 2], weight * taps[np.uint64(phase), 3]
        for lane in range(LANES):
            k = np.uint64(lane)  # which cannot be counted from the end, as LLVM need not consider
            found[k] += wa * lights[a + k] + wb * lights[b + k] + wc * lights[c + k] + wd * lights[d + k]
        there += slope
    for lane in range(LANES):
        found[lane] = min(max(found[lane], least), most)


@unaliased
def average_along(
    image: Floats,
    margin: int,
    near: Floats,
    table_of: Ints,
    paths: Floats,
    spacing: int,
    widest: int,
    alike: Single,
    nodes: Floats,
    taps: Floats,
    scratch: Floats,
    least: Single,
    most: Single,
    out: Floats,
) -> None:
    """The mean of an image along the path of each pixel.

    A path is a straight line. Along the axis it mostly follows, every pixel has as much weight as the kernel
    of the interpolation, moved along the line, gives it; across, the image is interpolated by the kernel.

    - `image`: (H + 2 margin, W + 2 margin, C) light with its edge repeated by `margin`, as far as any path
      reaches.
    - `near`, `table_of`: (H, W) inverse depth [1/m] and number of the table of what each pixel shows.
    - `paths`: (tables, rows, columns, 3, 4) middle of the path from the pixel along x and y, and its extent
      along x and y, at every `spacing` pixels, as polynomials of the inverse depth [px].
    - `nodes`, `scratch`: (tables, columns, 3, 4) and (2, 4) are used.
    - `least`, `most`: the range of the image, which the kernel would overshoot at edges.
    - `taps`: (PHASES + 1, 4) the kernel at four pixels, by how far the place lies beyond the second.
    - `widest`, `alike`: how many pixels a path may serve at most, no more than `MOST_AT_ONCE_PX`, and by how
      much their inverse depths may differ from the first's [px, 1/m].
    - `out`: (H W C + LANES,) is filled.
    """
    height, width = near.shape
    channels = image.shape[2]
    row_step = image.shape[1] * channels
    lights = image.reshape(image.size)
    half = np.float32(0.5)
    for y in range(height):
        _between_rows(paths, y // spacing, np.float32(y % spacing) / np.float32(spacing), nodes)
        x = 0
        while x < width:
            count = _alike(near, table_of, y, x, min(widest, width - x), alike)
            n, t = half * (near[y, x] + near[y, x + count - 1]), table_of[y, x]
            place = np.float32(x) + half * np.float32(count - 1)
            node = min(int(place) // spacing, nodes.shape[1] - 2)
            share = (place - np.float32(node * spacing)) / np.float32(spacing)
            u, v = _value(nodes, t, node, share, n, 0), _value(nodes, t, node, share, n, 1)
            along, aside = _value(nodes, t, node, share, n, 2), _value(nodes, t, node, share, n, 3)
            step_u, step_v = channels, row_step
            if abs(aside) > abs(along):
                u, v, along, aside = v, u, aside, along
                step_u, step_v = step_v, step_u
            slope = aside / along if along != 0 else np.float32(0)
            at = (y + margin) * row_step + (x + margin) * channels
            target = (y * width + x) * channels
            _average(lights, at, u, v, along, slope, step_u, step_v, taps, scratch, least, most, out, target)
            x += count
