"""Images through any lens, put together from pinhole pictures of the sides of a cube around it.

Renderers draw pinholes. A pixel of a fisheye is a sum of a few pixels of the sides that it looks at, and the
same ones in every frame: the way from pictures to image is a sparse matrix.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, vstack

from tacos_framework.camera.geometry import depth_of
from tacos_framework.camera.projection import rays_of_pixels
from tacos_framework.camera.resampling import SAME_SURFACE
from tacos_framework.values import Camera, ImageGeometry

Array = NDArray[np.float64]

DENSITY: Final = 1.5
"""Pixels of a side across one of the image: edges are then imaged within 0.05 px, and fall in one pixel no
less steeply than those of a pinhole. 1.25 gives 0.08 px for two thirds of the pixels."""

WIDEST_FLAT: Final = 1.8
"""Tangent up to which one picture serves for the whole image (61 degrees off the axis)."""

_COARSER: Final = 0.02
"""Share of the pixels that may see a side more coarsely than `DENSITY` says."""

_MARGIN_PX: Final = 3
_ROWS: Final = 128  # of the image, worked out together: bounds memory

_X, _Y, _Z = np.eye(3)
SIDES: Final = np.array(
    [(_X, _Y, _Z), (-_Z, _Y, _X), (_Z, _Y, -_X), (_X, -_Z, _Y), (_X, _Z, -_Y), (-_X, _Y, -_Z)]
)
"""(6, 3, 3) rotations from the camera's frame to that of a side: ahead, right, left, down, up, behind."""


@dataclass(frozen=True)
class Side:
    """A pinhole picture of one side of the cube, no larger than is looked at."""

    number: int
    width_px: int
    height_px: int
    focal_length_px: float
    centre_px: tuple[float, float]

    def camera(self, whole: Camera) -> Camera:
        """The pinhole that takes it, at the place of the camera whose image is put together."""
        turned = np.eye(4)
        turned[:3, :3] = SIDES[self.number].T
        return Camera(
            f"{whole.name}, side {self.number}",
            self.width_px,
            self.height_px,
            pixel_um=whole.pixel_um,
            focal_length_mm=self.focal_length_px * whole.pixel_um * 1e-3,
            agent_from_camera=whole.agent_from_camera @ turned,
            principal_point_px=self.centre_px,
        )


@dataclass(frozen=True, eq=False)
class Faces:
    """Assembly of an image of S pixels from P pixels of pictures, one picture after the other."""

    sides: tuple[Side, ...]
    light: csr_array
    """(S, P) shares of light; rows of what the lens does not image are empty."""
    around: NDArray[np.int32]
    shares: NDArray[np.float32]
    """(S, 4) pixels around what pixel centres look at, the nearest first, and what each counts in a linear
    mean.
    """
    imaged: NDArray[np.bool_]
    """(S,) whether the lens images anything there."""
    depth_over_z: Array
    """(S,) depth as `View.depth_m` has it, over that along the axis of the picture [1]."""

    def luminance(self, pictures: NDArray[np.float32]) -> NDArray[np.float32]:
        """(S, 3) light of (P, 3) [cd/m2]."""
        return np.asarray(self.light @ pictures, np.float32)

    def depth_m(self, along_axes_m: NDArray[np.float32]) -> NDArray[np.float32]:
        """(S,) depth of (P,) depths along the axes of pictures; infinite where nothing is seen [m]."""
        near = (np.float32(1) / along_axes_m)[self.around]
        lowest, highest = near.min(axis=1), near.max(axis=1)
        one_surface = highest - lowest <= SAME_SURFACE * highest
        chosen = np.where(one_surface, np.einsum("sk,sk->s", near, self.shares), near[:, 0])
        with np.errstate(divide="ignore"):
            return np.asarray(self.depth_over_z / np.where(self.imaged, chosen, 0.0), np.float32)

    def object_id(self, ids: NDArray[np.int32]) -> NDArray[np.int32]:
        """(S,) labels of (P,); 0 for what the lens does not image."""
        return np.where(self.imaged, ids[self.around[:, 0]], np.int32(0))


@lru_cache(maxsize=4)
def faces_of(geometry: ImageGeometry) -> Faces:
    """The pictures from which an image is put together, and how; kept for those used last."""
    bands = [*_looks(geometry)]
    sides = tuple(side for number in range(len(SIDES)) if (side := _side(number, bands)) is not None)
    parts = [_shares(looks, sides) for looks in bands]
    light, *of_centres = zip(*parts, strict=True)
    return Faces(sides, vstack(light, "csr"), *(np.concatenate(each) for each in of_centres))


@dataclass(frozen=True, eq=False)
class _Looks:
    """Directions of S pixels of an image."""

    side: NDArray[np.intp]
    """(S,) the side of the cube; -1 for none."""
    tangents: Array
    """(S, 2) where in it, x and y over the distance along its axis [1]."""
    moves: Array
    """(S, 2, 2) how that moves from column to column, and from row to row [1/px]."""
    depth_over_z: Array
    """(S,) depth over that along the side's axis [1]."""


_ABOUT_PX: Final = np.array([(0, 0), (0.25, 0), (-0.25, 0), (0, 0.25), (0, -0.25)])


def _looks(geometry: ImageGeometry) -> Iterator[_Looks]:
    """Directions of the image, some rows at a time."""
    ahead = _fits_one_side(geometry)
    for first in range(0, geometry.height_px, _ROWS):
        rows = np.arange(first, min(first + _ROWS, geometry.height_px))
        pixels = np.stack(np.meshgrid(np.arange(geometry.width_px), rows), axis=-1).reshape(-1, 2)
        rays = rays_of_pixels(pixels + _ABOUT_PX[:, None], geometry)
        imaged = np.isfinite(rays[0, :, 0])
        along = np.nan_to_num(rays[0]) @ SIDES[:, 2].T
        side = np.zeros(len(pixels), np.intp) if ahead else along.argmax(axis=1)
        x, y, z = np.einsum("sij,nsj->ins", SIDES[side], rays)
        places = np.stack([x / z, y / z], axis=-1)
        moves = np.stack([places[1] - places[2], places[3] - places[4]], axis=1) / 0.5
        yield _Looks(
            np.where(imaged, side, -1),
            np.nan_to_num(places[0]),
            np.nan_to_num(moves),  # at the rim of the image circle pixels count as points
            np.nan_to_num(depth_of(rays[0], geometry) / z[0], nan=1.0),
        )


def _fits_one_side(geometry: ImageGeometry) -> bool:
    x = np.linspace(-0.5, geometry.width_px - 0.5, 65)
    y = np.linspace(-0.5, geometry.height_px - 0.5, 65)
    rays = rays_of_pixels(np.stack(np.meshgrid(x, y), axis=-1), geometry)
    rays = rays[np.isfinite(rays[..., 0])]
    return bool((np.abs(rays[:, :2]).max(axis=1) <= WIDEST_FLAT * rays[:, 2]).all())


def _side(number: int, bands: list[_Looks]) -> Side | None:
    """The picture of a side, as fine and large as the pixels that look at it ask for; None where none do."""
    here = [looks.side == number for looks in bands]
    if not any(each.any() for each in here):
        return None
    tangents = np.concatenate([looks.tangents[each] for looks, each in zip(bands, here, strict=True)])
    moves = np.concatenate([looks.moves[each] for looks, each in zip(bands, here, strict=True)])
    steps = np.sqrt(np.abs(np.linalg.det(moves)))
    known = steps[steps > 0]
    focal_px = DENSITY / float(np.quantile(known, _COARSER)) if known.size else DENSITY
    lowest, highest = tangents.min(axis=0) * focal_px, tangents.max(axis=0) * focal_px
    corner = np.floor(lowest) - _MARGIN_PX
    width, height = (np.ceil(highest) + _MARGIN_PX - corner + 1).astype(int)
    return Side(number, int(width), int(height), focal_px, (float(-corner[0]), float(-corner[1])))


def _shares(
    looks: _Looks, sides: tuple[Side, ...]
) -> tuple[csr_array, NDArray[np.int32], NDArray[np.float32], NDArray[np.bool_], Array]:
    """Of some rows of the image, all of `Faces` but the sides."""
    starts = np.cumsum([0, *(side.width_px * side.height_px for side in sides)])
    count = len(looks.side)
    focal_px, width, start = np.ones(count), np.ones(count, np.intp), np.zeros(count, np.intp)
    centre = np.zeros((count, 2))
    for side, first in zip(sides, starts, strict=False):
        here = looks.side == side.number
        focal_px[here], width[here], start[here] = side.focal_length_px, side.width_px, first
        centre[here] = side.centre_px
    imaged = looks.side >= 0
    places = looks.tangents * focal_px[:, None] + centre
    moves = looks.moves * focal_px[:, None, None]
    density2 = np.maximum(np.abs(np.linalg.det(moves)), 1e-12)
    # A pixel's area has variance 1/12; a pixel of the picture and its linear neighbours bring 1/4 of theirs.
    aside = np.sqrt(np.maximum(1 / 12 - 0.25 / density2, 0.0))[:, None]
    across, down = moves[:, 0] * aside, moves[:, 1] * aside
    spread = [_taps(places + a * across + b * down, start, width) for a in (-1, 1) for b in (-1, 1)]
    taken = np.concatenate([pixels for pixels, _ in spread], axis=1)[imaged]
    weights = np.concatenate([shares for _, shares in spread], axis=1)[imaged] / np.float32(len(spread))
    ends = np.concatenate([[0], np.cumsum(np.where(imaged, 4 * len(spread), 0))])
    light = csr_array((weights.ravel(), taken.ravel(), ends), shape=(count, int(starts[-1])))
    light.sum_duplicates()

    around, shares = _taps(places, start, width)
    around[~imaged] = 0
    order = np.argsort(-shares, axis=1)
    nearest_first = np.take_along_axis(around, order, axis=1), np.take_along_axis(shares, order, axis=1)
    return light, *nearest_first, imaged, looks.depth_over_z


def _taps(
    places: Array, start: NDArray[np.intp], width: NDArray[np.intp]
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """(S, 4) pixels around (S, 2) places of pictures, and their shares in a linear mean."""
    corner = np.floor(places)
    left, top = corner.astype(np.intp).T
    x, y = (places - corner).T
    first = start + top * width + left
    pixels = np.stack([first, first + 1, first + width, first + width + 1], axis=1)
    shares = np.stack([(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y], axis=1)
    return pixels.astype(np.int32), shares.astype(np.float32)
