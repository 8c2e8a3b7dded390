"""Anti-aliasing where colour is costly and coverage cheap: shade once a pixel, look nine times.

Software OpenGL shades several times slower with multisampling. Instead colour is rendered once, at pixel
centres, and a second image tells which surface is seen at every half pixel. Where a pixel sees more than
one surface, its colour is the mean over those places, each with the colour of the nearest pixel centre
that sees the same surface. After subpixel reconstruction anti-aliasing (Chajdas, McGuire and Luebke,
I3D 2011); the mean over the pixel is the trapezoidal rule.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# Places around a pixel centre, in half pixels, and their weights in the mean.
_PLACES = np.array([(dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if dy or dx])
_WEIGHTS = (np.prod(2 - np.abs(_PLACES), axis=1) / 16).astype(np.float32)
_OWN_WEIGHT = np.float32(4 / 16)

# (8 places, 3 candidates, 2): the neighbouring pixels that share each place, nearer ones first.
_SHARED_BY = np.array([[(dy, 0), (0, dx), (dy, dx)] for dy, dx in _PLACES])

# Offsets in pixels that follow strips along rows and columns, nearest first.
_REACH = sorted(
    ((dy, dx) for dy in range(-10, 11) for dx in range(-10, 11) if min(abs(dy), abs(dx)) < 2 and (dy or dx)),
    key=lambda offset: offset[0] ** 2 + offset[1] ** 2,
)


def blend_edges(colour: NDArray[np.float32], surface: NDArray[np.float32]) -> None:
    """Average colour over each pixel that sees several surfaces, in place.

    Parameters
    ----------
    colour
        (H, W, 3) float32 linear colour at pixel centres; blended.
    surface
        (2 H + 1, 2 W + 1) float32 number of the surface seen at every half pixel: row 2 y + 1 and column
        2 x + 1 belong to the centre of pixel (x, y).

    Examples
    --------
    >>> colour = np.float32([[[0, 0, 0], [8, 8, 8]]])
    >>> surface = np.float32([[1, 1, 1, 2, 2]] * 3)  # the edge lies between the half pixels 2 and 3
    >>> blend_edges(colour, surface)
    >>> colour[..., 0].tolist()
    [[0.0, 6.0]]
    """
    width = colour.shape[1]
    pixel = np.flatnonzero(_sees_several(surface))
    if len(pixel) == 0:
        return
    row, column = np.divmod(pixel, width)
    stride = surface.shape[1]
    middle = (2 * row + 1) * stride + 2 * column + 1
    seen = surface.reshape(-1)[middle[:, None] + _PLACES @ [stride, 1]]  # (K, 8)

    # What pixel centres see, in a frame of pixels that see nothing known.
    centres = np.pad(surface[1::2, 1::2], 1, constant_values=-1).reshape(-1)
    framed = (row + 1) * (width + 2) + column + 1
    neighbours = _SHARED_BY @ [width + 2, 1]  # (8, 3)
    offsets = _SHARED_BY @ [width, 1]
    sees_same = centres[framed[:, None, None] + neighbours] == seen[..., None]  # (K, 8, 3)
    first = sees_same.argmax(axis=2)
    sees_other = seen != centres[framed][:, None]
    found = sees_same[..., 0] | sees_same[..., 1] | sees_same[..., 2]
    source = pixel[:, None] + np.where(sees_other & found, offsets[np.arange(8), first], 0)
    lost, place = np.nonzero(sees_other & ~found)
    source[lost, place] = _nearest_seeing(seen[lost, place], pixel[lost], surface[1::2, 1::2])

    flat = colour.reshape(-1, 3)
    flat[pixel] = np.einsum("kpc,p->kc", flat[source], _WEIGHTS) + _OWN_WEIGHT * flat[pixel]


def _nearest_seeing(
    wanted: NDArray[np.float32], pixel: NDArray[np.intp], centres: NDArray[np.float32]
) -> NDArray[np.intp]:
    """The pixel nearest to each of (N,) pixels whose centre sees a surface; itself where none is in reach.

    Strips thinner than a pixel are seen by few centres: their colour comes from along the strip, or they
    would break up into dashes.
    """
    height, width = centres.shape
    flat, nearest = centres.reshape(-1), pixel.copy()
    row, column = np.divmod(pixel, width)
    open_ = np.arange(len(pixel))
    for dy, dx in _REACH:
        y, x = row[open_] + dy, column[open_] + dx
        inside = (y >= 0) & (y < height) & (x >= 0) & (x < width)
        there = np.where(inside, y * width + x, 0)
        match = inside & (flat[there] == wanted[open_])
        nearest[open_[match]] = there[match]
        open_ = open_[~match]
    return nearest


def _sees_several(surface: NDArray[np.float32]) -> NDArray[np.bool_]:
    """(H, W) whether the nine places of a pixel see more than one surface."""
    changes = surface[:, 1:] != surface[:, :-1]
    in_row = changes[:, 0::2] | changes[:, 1::2]  # (2 H + 1, W) along any of the pixel's rows
    in_column = surface[1:, 1::2] != surface[:-1, 1::2]  # (2 H, W) along its middle column
    return in_row[0:-2:2] | in_row[1::2] | in_row[2::2] | in_column[0::2] | in_column[1::2]
