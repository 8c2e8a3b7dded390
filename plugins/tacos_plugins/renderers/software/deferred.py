"""Colour without OpenGL: first which triangle each pixel sees, then its shading, a batch of pixels at a time.

Every pixel is shaded once, whatever lies behind it, and pixels of one kind of surface go through the same
loops (`lookup_loops`, `light_loops`) together. After Burns and Hunt, "The visibility buffer: a cache-friendly
approach to deferred shading", JCGT 2013.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.renderers.light.flatten import SurfaceKind
from tacos_plugins.renderers.light.prefilter import PROBE_SCALE
from tacos_plugins.renderers.software.pixel_batch import PixelBatch
from tacos_plugins.renderers.software.shading_tables import ShadingTables, TexelStack

Step = Callable[[int], object]
"""Computes something for so many pixels of a batch."""


@dataclass(frozen=True, eq=False)
class Views:
    """A camera as each moving thing of a world sees it, first all that rests."""

    pixel_from_world: NDArray[np.float64]
    """(M, 3, 4) to homogeneous pixels [px m, m]."""
    rays: NDArray[np.float64]
    """(M, 4, 3) as `seen_triangles.interpolate` takes them."""


class DeferredShading:
    """Shades pixels of which it is known what they see.

    - `batch`, `between`: memory for pixels that are shaded together, and for those of them that mirror a
      second probe.
    """

    def __init__(self, batch: PixelBatch, between: PixelBatch, tables: ShadingTables):
        self._batch, self._between, self.tables = batch, between, tables

    def shade(
        self,
        views: Views,
        triangle: NDArray[np.int32],
        depth_m: NDArray[np.float32],
        luminance_cd_m2: NDArray[np.float32],
    ) -> None:
        """Fill in (H, W, 3) luminance [cd/m2].

        `triangle`, `depth_m`: (H, W) number of the triangle seen, 0 for none, and how far away it is [m].
        """
        # Compiled loops take a moment to import, which checking a recipe need not wait for.
        from tacos_plugins.renderers.software.seen_triangles import interpolate, planes, put, runs_by_kind

        tables, floats, integers = self.tables, self._batch.floats, self._batch.integers
        self._behind_all(views, triangle, luminance_cd_m2)
        runs, first, seen = runs_by_kind(triangle, tables.kind_of_triangle, len(tables.kinds))
        mesh = (tables.triangles, tables.position_m, tables.attributes, tables.mover_of_triangle)
        of_seen = np.empty((len(seen), tables.attributes.shape[1] + 1, 5))
        planes(seen, *mesh, views.pixel_from_world, of_seen)
        of_triangles = (depth_m, views.rays, tables.mover_of_triangle, tables.flat)
        for number, kind in enumerate(tables.kinds):
            of_kind, begin = runs[first[number] : first[number + 1]], (0, 0)
            if not len(of_kind):
                continue
            wanted = bool(kind & (SurfaceKind.TEXTURED | SurfaceKind.BUMPY)), SurfaceKind.GLOSSY in kind
            filled = (of_seen, tables.rows_of_kind[number], wanted, *of_triangles, floats, integers)
            steps = [*self._scattering(kind), *self._mirroring(kind)]
            while begin[0] < len(of_kind):
                count, begin = interpolate(of_kind, begin, *filled)
                for step in steps:
                    step(count)
                put(luminance_cd_m2.reshape(-1, 3), floats, integers, count)

    def _behind_all(
        self, views: Views, triangle: NDArray[np.int32], luminance_cd_m2: NDArray[np.float32]
    ) -> None:
        from tacos_plugins.renderers.software.background_loops import even, sky

        if self.tables.sky is None:
            even(self.tables.ambient_cd_m2, triangle, luminance_cd_m2)
        else:
            sky(self.tables.sky, views.rays[0], triangle, luminance_cd_m2)

    def _scattering(self, kind: SurfaceKind) -> Iterator[Step]:
        """Light that surfaces send into all directions."""
        from tacos_plugins.renderers.software.light_loops import scatter
        from tacos_plugins.renderers.software.lookup_loops import colours, light_of_maps, tilts

        tables, batch = self.tables, (self._batch.floats, self._batch.integers)
        textured, bumpy = SurfaceKind.TEXTURED in kind, SurfaceKind.BUMPY in kind
        if SurfaceKind.MAPPED in kind:
            yield partial(light_of_maps, tables.light_map, tables.bend_map, self._batch.floats)
        if bumpy:
            yield partial(tilts, *_looked_up(tables.normals), *batch)
        if textured:
            yield partial(colours, *_looked_up(tables.colours), *batch)
        yield lambda count: scatter(self._batch.floats, count, textured, bumpy)

    def _mirroring(self, kind: SurfaceKind) -> Iterator[Step]:
        """Light that glossy surfaces mirror, from one probe or between two, and that they emit."""
        from tacos_plugins.renderers.software import light_loops as loops
        from tacos_plugins.renderers.software.lookup_loops import look_into_probes

        if SurfaceKind.GLOSSY not in kind:
            return
        tables, batch = self.tables, (self._batch.floats, self._batch.integers)
        second = (self._between.floats, self._between.integers)
        probes = (tables.probes, tables.probe_boxes_m, len(tables.levels), PROBE_SCALE)

        def between_two(count: int) -> None:
            between = loops.between_two(*batch, count, *second)
            look_into_probes(*probes, *second, between)
            loops.add_second(self._batch.floats, *second, between)

        if SurfaceKind.BUMPY in kind:
            yield partial(loops.tilt_normals, self._batch.floats)
        yield partial(loops.mirror_rays, tables.probe_map, tables.map_origin, tables.materials, *batch)
        yield partial(look_into_probes, *probes, *batch)
        yield between_two
        yield partial(loops.reflect, tables.materials, *batch)


def _looked_up(stack: TexelStack) -> tuple[NDArray[np.int32], NDArray[np.int32], int]:
    return stack.texels, stack.offsets, stack.edge
