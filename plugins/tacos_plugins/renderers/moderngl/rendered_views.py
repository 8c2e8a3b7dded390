"""One picture of a world through one camera: colour without aliasing, depth and surfaces at pixel centres."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import moderngl
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera
from tacos_plugins.renderers.moderngl.context import flush
from tacos_plugins.renderers.moderngl.painter import Painter
from tacos_plugins.renderers.moderngl.targets import RenderTarget, TargetPool
from tacos_plugins.renderers.moderngl.viewpoint import Viewpoint

_BAND_ROWS = 64  # of pixels whose half pixels are drawn together, so that they stay in the cache


@dataclass(frozen=True, eq=False)
class RenderedView:
    luminance_cd_m2: NDArray[np.float32]
    """(H, W, 3) float32, averaged over each pixel [cd/m2]."""
    depth_m: NDArray[np.float32]
    """(H, W) float32 at pixel centres, infinite for nothing [m]."""
    surface: NDArray[np.float32]
    """(H, W) float32 number of the smooth surface at pixel centres, 0 for nothing. The next picture
    overwrites it.
    """


class Photographer(Protocol):
    """Takes pictures with one camera."""

    def take(self, painter: Painter, world_from_camera: NDArray[np.float64]) -> RenderedView: ...


class Multisampling:
    """Averages several samples of colour per pixel: for GPUs, which do it at little cost.

    - `camera`, `near_m`: the camera, and the least depth it sees [m].
    - `samples`: samples per pixel [1].
    """

    def __init__(self, targets: TargetPool, camera: Camera, near_m: float, samples: int):
        self._targets, self._camera, self._near_m, self._samples = targets, camera, near_m, samples
        self._shape = (camera.height_px, camera.width_px)
        self._geometry = targets.scratch("geometry", (*self._shape, 2))

    def take(self, painter: Painter, world_from_camera: NDArray[np.float64]) -> RenderedView:
        geometry, colour = self._draw(painter, world_from_camera)
        luminance = np.empty((*self._shape, 3), np.float32)
        geometry.read(self._geometry)
        colour.read(luminance)
        return self._picture(luminance)

    def take_all(self, shots: Sequence[tuple[Painter, NDArray[np.float64]]]) -> Iterator[RenderedView]:
        """The pictures of painters from poses, each copied to memory while the next one is drawn."""
        channels = (2, 3)
        pixels = math.prod(self._shape)
        slots = [[self._targets.buffer(4 * pixels * n, slot) for n in channels] for slot in range(2)]
        for number, (painter, pose) in enumerate(shots):
            drawn = zip(self._draw(painter, pose), channels, slots[number % 2], strict=True)
            for target, count, buffer in drawn:
                target.copy(buffer, count)
            if number > 0:
                yield self._copied(slots[(number - 1) % 2])
        if len(shots) > 0:
            yield self._copied(slots[(len(shots) - 1) % 2])

    def _draw(
        self, painter: Painter, world_from_camera: NDArray[np.float64]
    ) -> tuple[RenderTarget, RenderTarget]:
        view = painter.viewpoint(self._camera, world_from_camera, self._near_m)
        size = (self._camera.width_px, self._camera.height_px)
        geometry = self._targets.get(size, channels=2)
        colour = self._targets.get(size, channels=4, samples=self._samples)
        chunks = painter.in_view(view)
        painter.geometry(view, geometry, chunks)
        painter.colour(view, colour, chunks)
        return geometry, colour

    def _copied(self, buffers: Sequence[moderngl.Buffer]) -> RenderedView:
        luminance = np.empty((*self._shape, 3), np.float32)
        for array, buffer in zip((self._geometry, luminance), buffers, strict=True):
            buffer.read_into(array)
        return self._picture(luminance)

    def _picture(self, luminance: NDArray[np.float32]) -> RenderedView:
        return RenderedView(luminance, self._geometry[..., 0].copy(), self._geometry[..., 1])


class EdgeBlending:
    """Shades each pixel once and blends where surfaces meet (see `coverage`).

    - `camera`, `near_m`: the camera, and the least depth it sees [m].
    - `by_loops`: whether compiled loops shade rather than OpenGL, as is faster where that is software.
    """

    def __init__(self, targets: TargetPool, camera: Camera, near_m: float, by_loops: bool):
        self._by_loops = by_loops
        self._targets, self._camera, self._near_m = targets, camera, near_m
        self._half_pixels = half_pixel_camera(camera)
        height, width = camera.height_px, camera.width_px
        self._shape = (height, width)
        self._rows = min(_BAND_ROWS, height)
        band = (2 * self._rows + 1, 2 * width + 1)
        self._inverse_depth = targets.scratch("inverse depth", band)
        self._triangle = targets.scratch("triangle", band).view(np.int32)
        self._seen = targets.scratch("seen", self._shape)
        self._seen_triangle = targets.scratch("seen triangle", self._shape).view(np.int32)
        self._behind = targets.scratch("behind", self._shape)

    def take(self, painter: Painter, world_from_camera: NDArray[np.float64]) -> RenderedView:
        from tacos_plugins.renderers.software.coverage import find_edges  # takes a moment to import

        view = painter.viewpoint(self._camera, world_from_camera, self._near_m)
        fine = painter.viewpoint(self._half_pixels, world_from_camera, self._near_m)
        chunks = painter.in_view(fine)  # which sees half a pixel more on every side
        depth_m = np.empty(self._shape, np.float32)
        pixel, wanted = self._look(painter, view, fine, chunks, depth_m)

        if self._by_loops:
            luminance = painter.shade(view, self._seen_triangle, depth_m)
            edges = find_edges(pixel, wanted, self._seen)
        else:
            colour = self._targets.get(self._shape[::-1], channels=4, fills_depth=True)
            painter.colour(view, colour, painter.with_surfaces(chunks, self._seen), self._behind)
            flush()
            edges = find_edges(pixel, wanted, self._seen)  # while others draw colour
            luminance = np.empty((*self._shape, 3), np.float32)
            colour.read(luminance)
        edges.blend(luminance)
        return RenderedView(luminance, depth_m, self._seen)

    def _look(
        self,
        painter: Painter,
        view: Viewpoint,
        fine: Viewpoint,
        chunks: NDArray[np.intp],
        depth_m: NDArray[np.float32],
    ) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Fill in what pixel centres see, band by band; the pixels that see several surfaces, and which.

        Half pixels of a whole image at many megapixels are fetched from memory each time a triangle covers
        them; those of a band stay in the cache.
        """
        from tacos_plugins.renderers.software.coverage import seeing_several
        from tacos_plugins.renderers.software.visibility import at_centres, farthest_behind, look

        projected, several = painter.projected(fine, chunks), []
        of_surface = painter.world.surface_of_triangle
        for first in range(0, self._shape[0], self._rows):
            here = slice(first, min(first + self._rows, self._shape[0]))
            lines = slice(2 * (here.stop - first) + 1)
            inverse_depth, triangle = self._inverse_depth[lines], self._triangle[lines]
            look(projected, inverse_depth, triangle, 2 * first)
            of_rows = (depth_m[here], self._seen_triangle[here], self._seen[here])
            at_centres(inverse_depth, triangle, of_surface, *of_rows)
            if not self._by_loops:
                farthest_behind(inverse_depth, view.window_of_inverse, self._behind[here])
            several.append(seeing_several(triangle, of_surface, first))
        pixel, wanted = zip(*several, strict=True)
        return np.concatenate(pixel), np.concatenate(wanted)


def half_pixel_camera(camera: Camera) -> Camera:
    """The same view at every half pixel: row 2 y + 1 and column 2 x + 1 are the centre of pixel (x, y).

    >>> fine = half_pixel_camera(Camera("c", 4, 3, pixel_um=2.0, focal_length_mm=1.0))
    >>> fine.width_px, fine.height_px, fine.centre_px, fine.focal_length_px
    (9, 7, (4.0, 3.0), 1000.0)
    """
    cx, cy = camera.centre_px
    return replace(
        camera,
        width_px=2 * camera.width_px + 1,
        height_px=2 * camera.height_px + 1,
        binning=camera.binning / 2,
        principal_point_px=(2 * cx + 1, 2 * cy + 1),
    )
