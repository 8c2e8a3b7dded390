"""Draws one world, as it is at a moment, for one camera pose."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera
from tacos_plugins.renderers.light.flatten import SurfaceKind
from tacos_plugins.renderers.moderngl.culling import DrawList
from tacos_plugins.renderers.moderngl.drawn_world import DrawnWorld
from tacos_plugins.renderers.moderngl.targets import RenderTarget
from tacos_plugins.renderers.moderngl.viewpoint import Viewpoint, viewpoint
from tacos_plugins.renderers.software.deferred import Views

if TYPE_CHECKING:
    from tacos_plugins.renderers.software.projected import Projected


class Painter:
    """Draws one world.

    - `world`: the world, owned from now on.
    """

    def __init__(self, world: DrawnWorld):
        self.world = world
        self._moved: Mapping[int, NDArray[np.float64]] = {}

    def with_moved(self, moved: Mapping[int, NDArray[np.float64]]) -> Painter:
        """This painter, drawing objects where (4, 4) transforms by id take them from where they rest [m]."""
        there = copy(self)
        there._moved = moved
        return there

    def in_view(self, view: Viewpoint) -> NDArray[np.intp]:
        """The chunks of the world that a camera may see."""
        return self.world.culling.in_frustum(view.clip_from_world)

    def with_surfaces(self, chunks: NDArray[np.intp], seen: NDArray[np.float32]) -> NDArray[np.intp]:
        """Those chunks that hold any of the surfaces in an image of surface numbers."""
        return self.world.culling.with_surfaces(chunks, seen)

    def geometry(self, view: Viewpoint, target: RenderTarget, chunks: NDArray[np.intp]) -> None:
        """Draw depth [m] and surface number into a target of 2 channels by OpenGL; inf and 0 for nothing."""
        self.world.by_gl.geometry(partial(self._seen, view), target, self._to_see(view, chunks))

    def colour(
        self,
        view: Viewpoint,
        target: RenderTarget,
        chunks: NDArray[np.intp],
        behind: NDArray[np.float32] | None = None,
    ) -> None:
        """Draw luminance into a target of 4 channels by OpenGL [cd/m2].

        `behind`: (H, W) window depths beyond which nothing is seen, and nothing need be shaded [1].
        """
        draws = self.world.culling.draw_list(chunks, view.eye_m, ~SurfaceKind(0))
        self.world.by_gl.colour(partial(self._seen, view), target, draws, behind)

    def shade(
        self, view: Viewpoint, triangle: NDArray[np.int32], depth_m: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """(H, W, 3) luminance of what pixels see, without OpenGL [cd/m2].

        `triangle`, `depth_m`: (H, W) number of the triangle seen, 0 for none, and how far away it is [m].
        """
        shading = self.world.by_loops
        seen = [self._seen(view, mover) for mover in shading.tables.movers.tolist()]
        views = Views(
            np.stack([each.pixel_from_world for each in seen]),
            np.stack([np.vstack([each.pixel_rays, each.eye_m]) for each in seen]),
        )
        luminance = np.empty((*triangle.shape, 3), np.float32)
        shading.shade(views, triangle, depth_m, luminance)
        return luminance

    def projected(self, view: Viewpoint, chunks: NDArray[np.intp]) -> list[Projected]:
        """The triangles of some chunks on the image, for what is seen to be drawn without OpenGL."""
        # Compiled loops take a moment to import, which checking a recipe need not wait for.
        from tacos_plugins.renderers.software.projected import project

        camera, mesh = view.camera, (self.world.position_m, self.world.triangles)
        shape = (camera.height_px, camera.width_px)
        draws = self._to_see(view, chunks)
        found = []
        for mover, bits, first, count in draws.groups:
            pixel_from_world = self._seen(view, mover).pixel_from_world
            closed = bool(bits & SurfaceKind.CLOSED)
            runs = draws.runs(first, count)
            found.append(project(*mesh, runs, pixel_from_world, shape, view.near_m, closed))
        return found

    def _to_see(self, view: Viewpoint, chunks: NDArray[np.intp]) -> DrawList:
        """Draw list of some chunks, to know what is seen."""
        return self.world.culling.draw_list(chunks, view.eye_m, SurfaceKind.CLOSED)

    def viewpoint(self, camera: Camera, world_from_camera: NDArray[np.float64], near_m: float) -> Viewpoint:
        return viewpoint(camera, world_from_camera, near_m, self.world.far_m(world_from_camera[:3, 3]))

    def release(self) -> None:
        self.world.release()

    def _seen(self, view: Viewpoint, mover: int) -> Viewpoint:
        """The view of an object that may have moved."""
        return view.onto(self._moved[mover]) if mover in self._moved else view
