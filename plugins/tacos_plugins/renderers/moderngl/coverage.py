"""Anti-aliasing where colour is costly and coverage cheap: shade once a pixel, look nine times.

Software OpenGL shades several times slower with multisampling. Instead colour is rendered once, at pixel
centres, and a second image tells which surface is seen at every half pixel. Where a pixel sees more than
one surface, its colour is the mean over those places, each with the colour of the nearest pixel centre
that sees the same surface. After subpixel reconstruction anti-aliasing (Chajdas, McGuire and Luebke,
I3D 2011); the mean over the pixel is the trapezoidal rule.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

# Places around a pixel centre, in half pixels, and their weights in the mean.
_PLACES = np.array([(dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if dy or dx])
_WEIGHTS = (np.prod(2 - np.abs(_PLACES), axis=1) / 16).astype(np.float32)
_OWN_WEIGHT = np.float32(4 / 16)

# (8 places, 3 candidates, 2): the neighbouring pixels that share each place, nearer ones first.
_SHARED_BY = np.array([[(dy, 0), (0, dx), (dy, dx)] for dy, dx in _PLACES])

# Offsets in pixels that follow strips along rows and columns, nearest first.
_REACH = np.array(
    sorted(
        ((y, x) for y in range(-10, 11) for x in range(-10, 11) if min(abs(y), abs(x)) < 2 and (y or x)),
        key=lambda offset: offset[0] ** 2 + offset[1] ** 2,
    )
)
_RINGS = (slice(0, 16), slice(16, 48), slice(48, None))  # most is found in the first


@dataclass(frozen=True, eq=False)
class Edges:
    """Pixels that see several surfaces, and the pixels their colours come from.

    Parameters
    ----------
    pixel
        (K,) index of each such pixel, row by row.
    source
        (8, K) index of the pixel whose colour stands for each place around it.
    """

    pixel: NDArray[np.intp]
    source: NDArray[np.intp]

    def blend(self, colour: NDArray[np.float32]) -> None:
        """Average (H, W, 3) float32 linear colour over each of the pixels, in place."""
        colours = colour.reshape(-1, 3)
        around = np.einsum("pkc,p->kc", colours[self.source], _WEIGHTS)
        colours[self.pixel] = around + _OWN_WEIGHT * colours[self.pixel]


def find_edges(surface: NDArray[np.float32]) -> Edges:
    """Find the pixels that see several surfaces.

    Parameters
    ----------
    surface
        (2 H + 1, 2 W + 1) float32 number of the surface seen at every half pixel: row 2 y + 1 and column
        2 x + 1 belong to the centre of pixel (x, y).

    Examples
    --------
    >>> colour = np.float32([[[0, 0, 0], [8, 8, 8]]])
    >>> surface = np.float32([[1, 1, 1, 2, 2]] * 3)  # the edge lies between the half pixels 2 and 3
    >>> find_edges(surface).blend(colour)
    >>> colour[..., 0].tolist()
    [[0.0, 6.0]]
    """
    width = surface.shape[1] // 2
    pixel = np.flatnonzero(_sees_several(surface))
    row, column = np.divmod(pixel, width)
    stride = surface.shape[1]
    middle = (2 * row + 1) * stride + 2 * column + 1
    flat = surface.reshape(-1)
    seen = flat[(_PLACES @ [stride, 1])[:, None] + middle]  # (8, K)
    place, which = np.nonzero(seen != flat[middle])
    wanted, at = seen[place, which], pixel[which]

    # What pixel centres see, in a frame of pixels that see nothing known.
    centres = surface[1::2, 1::2]
    framed = np.pad(centres, 1, constant_values=-1).reshape(-1)
    in_frame = (row[which] + 1) * (width + 2) + column[which] + 1
    found, nearest = np.zeros(len(at), dtype=bool), at.copy()
    for candidate in _SHARED_BY.transpose(1, 0, 2)[::-1]:  # later ones are nearer and overrule
        same = framed[in_frame + (candidate @ [width + 2, 1])[place]] == wanted
        nearest = np.where(same, at + (candidate @ [width, 1])[place], nearest)
        found |= same
    lost = np.flatnonzero(~found)
    nearest[lost] = _nearest_seeing(wanted[lost], at[lost], centres)

    source = np.tile(pixel, (len(_PLACES), 1))
    source[place, which] = nearest
    return Edges(pixel, source)


def _nearest_seeing(
    wanted: NDArray[np.float32], pixel: NDArray[np.intp], centres: NDArray[np.float32]
) -> NDArray[np.intp]:
    """The pixel nearest to each of (N,) pixels whose centre sees a surface; itself where none is in reach.

    Strips thinner than a pixel are seen by few centres: their colour comes from along the strip, or they
    would break up into dashes.
    """
    height, width = centres.shape
    nearest = pixel.copy()
    row, column = np.divmod(pixel, width)
    open_ = np.arange(len(pixel))
    for ring in _RINGS:
        y = row[open_, None] + _REACH[ring, 0]
        x = column[open_, None] + _REACH[ring, 1]
        inside = (y >= 0) & (y < height) & (x >= 0) & (x < width)
        match = inside & (centres[np.where(inside, y, 0), np.where(inside, x, 0)] == wanted[open_, None])
        first = match.argmax(axis=1)
        found = match[np.arange(len(open_)), first]
        there = open_[found]
        nearest[there] = (row[there] + _REACH[ring, 0][first[found]]) * width
        nearest[there] += column[there] + _REACH[ring, 1][first[found]]
        open_ = open_[~found]
    return nearest


def _sees_several(surface: NDArray[np.float32]) -> NDArray[np.bool_]:
    """(H, W) whether the nine places of a pixel see more than one surface."""
    changes = surface[:, 1:] != surface[:, :-1]
    in_row = changes.view(np.uint16) != 0  # (2 H + 1, W): either of the two changes between a pixel's places
    in_column = surface[1:, 1::2] != surface[:-1, 1::2]  # (2 H, W) along its middle column
    return in_row[0:-2:2] | in_row[1::2] | in_row[2::2] | in_column[0::2] | in_column[1::2]
