"""The way of what each pixel shows over the image, on a grid of nodes and over inverse depth.

Where a ray meets a surface some milliseconds earlier or later is a smooth function of the pixel and of the
inverse depth, whatever the lens. It is worked out at nodes by the geometry of the camera, once for what
stands still and once for each thing that moves by itself; loops over pixels look it up.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import ImageContext, ImageGeometry
from tacos_plugins.effects.path_loops import MOST_AT_ONCE_PX

SPACING_PX = (16, 32)
"""From node to node, least and most; between them displacements are linear to a hundredth of a pixel [px]."""

_SPACING_OF_ROOT = 1.5
"""Spacing over the root of the focal length: displacements bend over a focal length, squared by the step."""

_BENT_PX = 0.1
"""A path that lies farther from its chord is cut in two [px]."""

_MOST_PARTS = 16

_ALIKE_PX = 0.04
"""Neighbours whose places differ by less from those by one path take it together [px]."""

_SHOWN_ALIKE_PX = 0.2
"""The same where only whole pixels are looked up [px]."""

_BOOLE = np.array([7, 32, 12, 32, 7]) / 90
"""Weights of five even places on a path for its mean."""

RowAfter = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Takes rows to the middles of their exposures after the frame's moment [px, s]."""

Displaced = Callable[
    [NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
]
"""Takes columns, rows, inverse depths of the frame and times after its moment, which broadcast, to columns
and rows in the frame and inverse depths at the time."""


@dataclass(frozen=True, eq=False)
class Paths:
    """Figures of paths at nodes, as polynomials of the inverse depth in the frame."""

    parts: Sequence[NDArray[np.float32]]
    """One or several (tables, rows, columns, 3, figures); the first two are places along x and y from the
    pixel, then come extents along both, or the inverse depth then [px, px, 1/m].
    """
    reach_px: float
    """No path goes farther from its pixel [px]."""
    spacing_px: int
    """From node to node [px]."""
    widest: int
    """So many neighbours may take the path of one [1]."""
    alike: np.float32
    """Largest difference of their inverse depths from the first's [1/m]."""

    @property
    def row_shape(self) -> tuple[int, ...]:
        """Of one row of the nodes of all tables."""
        tables, _, *rest = self.parts[0].shape
        return tables, *rest


@dataclass(frozen=True, eq=False)
class ImageMotion:
    """Motion of a frame's image."""

    displaced: Sequence[Displaced]
    """For each table the function of its motion: what stands still first, then what moves by itself."""
    table_of: NDArray[np.int32]
    """(H, W) int32 which of them each pixel has."""
    near: NDArray[np.float32]
    """(H, W) float32 inverse depth of the frame [1/m]."""
    object_id: NDArray[np.int32]
    """(H, W) int32 what it shows; where objects are not known, alike everywhere."""
    spacing_px: int
    """From node to node of the tables [px]."""

    @classmethod
    def of(cls, geometry: ImageGeometry, context: ImageContext, frame: int) -> ImageMotion:
        """That of a rendered frame, or of an image with a known velocity.

        Raises `ContextMissing` where neither is known.
        """
        size = geometry.height_px, geometry.width_px
        still = np.zeros(size, np.int32)
        if context.motion is None:
            velocity = np.asarray(context.known_velocity_px_s("effect.motion"), np.float64)
            if velocity.ndim == 1:
                return cls([_steadily(velocity)], still, np.zeros(size, np.float32), still, max(size))
            velocity = velocity if velocity.ndim == 3 else velocity[frame]
            return cls([_steadily(velocity)], still, np.zeros(size, np.float32), still, 1)
        depth_m = context.known_depth_m("effect.motion")
        depth_m = depth_m if depth_m.ndim == 2 else depth_m[frame]
        near = np.divide(np.float32(1), depth_m, dtype=np.float32)
        displaced: list[Displaced] = [context.motion.shown]
        table_of: NDArray[np.int32] = still
        ids: NDArray[np.int32] = still
        if context.object_id is not None:
            shown = context.object_id if context.object_id.ndim == 2 else context.object_id[frame]
            ids = shown.astype(np.int32, copy=False)
        if context.object_id is not None and context.motion.movers:
            seen = np.bincount(ids.ravel(), minlength=max(context.motion.movers) + 1)
            moving = [each for each in sorted(context.motion.movers) if seen[each]]
            table = np.zeros(len(seen), np.int32)
            table[moving] = np.arange(len(moving)) + 1
            table_of = table[ids]
            displaced += [_of_object(context.motion.shown, each) for each in moving]
        spacing_px = int(np.clip(_SPACING_OF_ROOT * np.sqrt(geometry.focal_length_px), *SPACING_PX))
        return cls(displaced, table_of, near, ids, spacing_px)

    def paths(self, row_after_s: RowAfter, exposure_s: float) -> Paths:
        """The straight parts of the paths over an exposure, which all have the same time.

        `row_after_s`: takes rows to the middles of their exposures after the frame's moment [px, s].
        `exposure_s`: how long each row is exposed [s].
        """
        parts = 1
        while True:
            moments_s = exposure_s * np.linspace(-0.5, 0.5, 4 * parts + 1)
            knots = self._at_nodes(row_after_s, moments_s)[..., :2]
            runs = np.stack([knots[k : 4 * parts - 3 + k : 4] for k in range(5)], axis=-1)
            begin, end = runs[..., 0], runs[..., -1]
            straight = begin[..., None] + (end - begin)[..., None] * np.linspace(0, 1, 5)
            if np.abs(runs - straight).max() <= _BENT_PX or parts == _MOST_PARTS:
                break
            parts *= 2
        mean = runs @ _BOOLE
        return self._paths(
            np.concatenate([mean, end - begin], axis=-1), float(np.abs(knots).max()), _ALIKE_PX
        )

    def middle(self, row_after_s: RowAfter) -> Paths:
        """Places and inverse depths in the middle of each row's exposure."""
        values = self._at_nodes(row_after_s, np.zeros(1))
        return self._paths(values, float(np.abs(values[..., :2]).max()), _SHOWN_ALIKE_PX)

    def _paths(self, values: NDArray[np.float64], reach_px: float, alike_px: float) -> Paths:
        """Of (parts, tables, rows, columns, 3, figures) at `_nears`."""
        places = values[..., :2]
        over_px = np.abs(np.diff(places, axis=3)).max() / self.spacing_px
        over_near = np.abs(np.diff(places, axis=4)).max() / self._nears[1]
        return Paths(
            [self._polynomials(part) for part in values],
            reach_px,
            self.spacing_px,
            widest=int(np.clip(1 + 2 * alike_px / max(over_px, 1e-9), 1, MOST_AT_ONCE_PX)),
            alike=np.float32(2 * alike_px / max(over_near, 1e-9)),
        )

    def _at_nodes(self, row_after_s: RowAfter, offsets_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """(moments, tables, rows, columns, 3, 3) displacement along x and y, and inverse depth."""
        height, width = self.near.shape
        step = self.spacing_px
        x = step * np.arange((width - 1) // step + 2, dtype=np.float64)[None, :, None]
        y = step * np.arange((height - 1) // step + 2, dtype=np.float64)[:, None, None]
        after_s = row_after_s(y) + offsets_s[:, None, None, None]
        found = []
        for displaced in self.displaced:
            there_x, there_y, near = np.broadcast_arrays(*displaced(x, y, self._nears, after_s))
            found.append(np.stack([there_x - x, there_y - y, near], axis=-1))
        return np.stack(found, axis=1)

    @property
    def _nears(self) -> NDArray[np.float64]:
        """(3,) inverse depths at which paths are worked out: far away, half-way, and the nearest [1/m]."""
        return np.array([0.0, 0.5, 1.0]) * (float(self.near.max()) or 1.0)

    def _polynomials(self, values: NDArray[np.float64]) -> NDArray[np.float32]:
        """Those of the inverse depth through values at `_nears`, along the axis before the last."""
        far, half, nearest = np.moveaxis(values, -2, 0)
        scale = self._nears[-1]
        linear, square = (4 * half - 3 * far - nearest) / scale, (2 * far - 4 * half + 2 * nearest) / scale**2
        return np.ascontiguousarray(np.stack([far, linear, square], axis=-2), np.float32)


def _steadily(velocity_px_s: NDArray[np.float64]) -> Displaced:
    """The motion of an image whose pixels have (2,) or (H, W, 2) steady velocities."""

    def displaced(
        x: NDArray[np.float64],
        y: NDArray[np.float64],
        near: NDArray[np.float64],
        after_s: NDArray[np.float64],
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        velocity = velocity_px_s
        if velocity.ndim == 3:
            last_y, last_x = velocity.shape[0] - 1, velocity.shape[1] - 1
            velocity = velocity[np.minimum(y, last_y).astype(int), np.minimum(x, last_x).astype(int)]
        return x - velocity[..., 0] * after_s, y - velocity[..., 1] * after_s, near

    return displaced


def _of_object(displaced: Callable[..., Any], object_id: int) -> Displaced:
    return lambda x, y, near, after_s: displaced(x, y, near, after_s, object_id)
