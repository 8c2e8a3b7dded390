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

from tacos_plugins.compiled.loops import compiled, unaliased

# Places around a pixel centre, in half pixels, and their weights in the mean.
_PLACES = np.array([(dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if dy or dx])
_WEIGHTS = (np.prod(2 - np.abs(_PLACES), axis=1) / 16).astype(np.float32)
_OWN_WEIGHT = np.float32(4 / 16)

# Pixels to take a colour from, nearest first: along strips that follow rows or columns.
_REACH = np.array(
    sorted(
        ((y, x) for y in range(-10, 11) for x in range(-10, 11) if min(abs(y), abs(x)) < 2 and (y or x)),
        key=lambda offset: offset[0] ** 2 + offset[1] ** 2,
    )
)


@dataclass(frozen=True, eq=False)
class Edges:
    """Pixels that see several surfaces, and the pixels their colours come from."""

    pixel: NDArray[np.int32]
    """(K,) int32 index of each such pixel, row by row."""
    source: NDArray[np.int32]
    """(K, 8) int32 index of the pixel whose colour stands for each place around it."""

    def blend(self, colour: NDArray[np.float32]) -> None:
        """Average (H, W, 3) float32 linear colour over each of the pixels, in place."""
        _blend(colour.reshape(-1, 3), self.pixel, self.source)


def find_edges(pixel: NDArray[np.int32], wanted: NDArray[np.int32], seen: NDArray[np.float32]) -> Edges:
    """Find what pixels that see several surfaces are blended from.

    Strips thinner than a pixel are seen by few centres: their colour comes from along the strip, or they
    would break up into dashes. A surface that no centre in reach sees has the colour of the pixel itself.

    `pixel`, `wanted`: as `seeing_several` gives them. `seen`: (H, W) number of the surface seen at the centre
    of each pixel.

    >>> colour = np.float32([[[0, 0, 0], [8, 8, 8]]])
    >>> triangle = np.int32([[1, 1, 1, 2, 2]] * 3)  # the edge lies between the half pixels 2 and 3
    >>> of_surface = np.int32([0, 1, 2])
    >>> seen = of_surface[triangle[1::2, 1::2]].astype(np.float32)
    >>> find_edges(*seeing_several(triangle, of_surface, 0), seen).blend(colour)
    >>> colour[..., 0].tolist()
    [[0.0, 6.0]]
    """
    source = np.empty((len(pixel), 8), np.int32)
    _find_sources(seen, pixel, wanted, source)
    return Edges(pixel, source)


def seeing_several(
    triangle: NDArray[np.int32], surface_of_triangle: NDArray[np.int32], first_row: int
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """The pixels whose nine places see more than one surface.

    - `triangle`: (2 R + 1, 2 W + 1) number of the triangle seen at every half pixel of R rows: row 2 y + 1
      and column 2 x + 1 belong to the centre of a pixel.
    - `surface_of_triangle`: (T + 1,) the surface that each triangle is of, 0 for no triangle.
    - `first_row`: row of the image that the first of them is.

    Returns:

    - `pixel`: (K,) index in the image.
    - `wanted`: (K, 8) surface seen at each place around.
    """
    height, width = triangle.shape[0] // 2, triangle.shape[1] // 2
    pixel, wanted = np.empty(height * width, np.int32), np.empty((height * width, 8), np.int32)
    count = _find_several(triangle, surface_of_triangle, first_row * width, pixel, wanted)
    return pixel[:count], wanted[:count]


@compiled
def _find_several(
    triangle: NDArray[np.int32],
    surface_of_triangle: NDArray[np.int32],
    first_pixel: int,
    pixel: NDArray[np.int32],
    wanted: NDArray[np.int32],
) -> int:
    """Fill in what `seeing_several` gives; how many there are."""
    height, width = triangle.shape[0] // 2, triangle.shape[1] // 2
    differs = np.empty(2 * width, np.int32)
    both = differs.view(np.int64)
    count = 0
    for y in range(height):
        above, middle, below = triangle[2 * y], triangle[2 * y + 1], triangle[2 * y + 2]
        _find_differences(above, middle, below, differs)
        for x in range(width):
            if both[x]:  # triangles, which may be of one surface
                own = surface_of_triangle[middle[2 * x + 1]]
                differ = False
                for place in range(8):
                    row, column = 2 * y + 1 + _PLACES[place, 0], 2 * x + 1 + _PLACES[place, 1]
                    surface = surface_of_triangle[triangle[row, column]]
                    wanted[count, place] = surface
                    differ |= surface != own
                pixel[count] = first_pixel + y * width + x
                count += differ  # else the next pixel takes its place
    return count


@unaliased
def _find_differences(
    above: NDArray[np.int32], middle: NDArray[np.int32], below: NDArray[np.int32], differs: NDArray[np.int32]
) -> None:
    """Fill in, for each two columns side by side of three rows (2 W + 1,), whether they differ: 0 if not."""
    for x in range(len(differs)):
        here, following = middle[x], middle[x + 1]
        down = (above[x] ^ here) | (below[x] ^ here)
        differs[x] = down | (here ^ following) | (above[x + 1] ^ following) | (below[x + 1] ^ following)


@compiled
def _find_sources(
    seen: NDArray[np.float32], pixel: NDArray[np.int32], wanted: NDArray[np.int32], source: NDArray[np.int32]
) -> None:
    """Fill in the nearest pixel whose centre sees what each place around one sees; itself if none does."""
    width = seen.shape[1]
    for index in range(len(pixel)):
        y, x = pixel[index] // width, pixel[index] % width
        for place in range(8):
            dy, dx = _PLACES[place, 0], _PLACES[place, 1]
            number = np.float32(wanted[index, place])
            found = _sees(seen, y, x, number)
            row, column = y, x
            # Pixels that share the place come first: they are nearer to it than any other.
            for sharing in range(3):
                if not found:
                    row = y + dy * (sharing != 1)
                    column = x + dx * (sharing != 0)
                    found = _sees(seen, row, column, number)
            for nearby in range(len(_REACH)):
                if found:
                    break
                row, column = y + _REACH[nearby, 0], x + _REACH[nearby, 1]
                found = _sees(seen, row, column, number)
            source[index, place] = row * width + column if found else pixel[index]


@compiled
def _sees(seen: NDArray[np.float32], row: int, column: int, wanted: np.float32) -> bool:
    """True if a pixel lies in the image and its centre sees a surface."""
    height, width = seen.shape
    inside = (row >= 0) and (row < height) and (column >= 0) and (column < width)
    return inside and seen[row, column] == wanted


@compiled
def _blend(colour: NDArray[np.float32], pixel: NDArray[np.int32], source: NDArray[np.int32]) -> None:
    mean = np.empty((len(pixel), 3), np.float32)  # kept apart, as blended pixels are sources of others
    for index in range(len(pixel)):
        for channel in range(3):
            total = _OWN_WEIGHT * colour[pixel[index], channel]
            for place in range(8):
                total += _WEIGHTS[place] * colour[source[index, place], channel]
            mean[index, channel] = total
    for index in range(len(pixel)):
        for channel in range(3):
            colour[pixel[index], channel] = mean[index, channel]
