"""A lit world, ready to be drawn: by OpenGL, or by compiled loops where OpenGL is software."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tacos_framework import World
from tacos_plugins.renderers.light.baked_mesh import BakedMesh
from tacos_plugins.renderers.light.probe_map import ProbeMap
from tacos_plugins.renderers.light.probes import Probe
from tacos_plugins.renderers.moderngl.culling import Culling
from tacos_plugins.renderers.moderngl.gl_drawing import GlDrawing, Programs
from tacos_plugins.renderers.moderngl.gpu_world import GpuWorld
from tacos_plugins.renderers.software.deferred import DeferredShading
from tacos_plugins.renderers.software.pixel_batch import PixelBatch
from tacos_plugins.renderers.software.shading_tables import ShadingTables


class DrawnWorld:
    """One world, and what it is drawn with, made when it is first drawn that way."""

    def __init__(
        self, programs: Programs, batches: tuple[PixelBatch, PixelBatch], world: World, lit: BakedMesh
    ):
        mesh = lit.mesh
        self._programs, self._batches = programs, batches
        self._source: tuple[World, BakedMesh] | None = (world, lit)
        self._probes: tuple[Sequence[Probe], ProbeMap] | None = None
        self.culling = Culling(lit.chunks, mesh.triangles, lit.surface)
        self.object_of_surface = np.zeros(int(lit.surface.max(initial=0)) + 1, np.int32)
        self.object_of_surface[lit.surface] = mesh.object_id
        self.surface_of_triangle = np.append(np.int32(0), lit.surface[mesh.triangles[:, 0]]).astype(np.int32)
        self.position_m, self.triangles = mesh.position_m, mesh.triangles
        self.lower_m, self.upper_m = _bounds(mesh.position_m)

    def mirror(self, probes: Sequence[Probe], mapped: ProbeMap) -> None:
        """Let glossy surfaces mirror the probes that a map gives each place; before, they mirror darkness."""
        self._probes = probes, mapped
        if "by_gl" in vars(self):
            self.by_gl.world.set_probes(probes, mapped)
        if "by_loops" in vars(self):
            self.by_loops.tables.set_probes(probes, mapped)

    def upload(self) -> None:
        """Have OpenGL hold the world, and no longer keep here what only loops would need."""
        _ = self.by_gl  # made by being asked for
        self._source = None

    @cached_property
    def by_gl(self) -> GlDrawing:
        """Its drawing by OpenGL."""
        assert self._source is not None
        drawing = GlDrawing(self._programs, GpuWorld(self._programs.context, *self._source))
        if self._probes is not None:
            drawing.world.set_probes(*self._probes)
        return drawing

    @cached_property
    def by_loops(self) -> DeferredShading:
        """Its shading by loops."""
        assert self._source is not None
        tables = ShadingTables(*self._source)
        if self._probes is not None:
            tables.set_probes(*self._probes)
        return DeferredShading(*self._batches, tables)

    def far_m(self, eye_m: NDArray[np.float64]) -> float:
        """A depth beyond everything that can be seen from an optical centre [m]."""
        farthest = np.maximum(np.abs(self.lower_m - eye_m), np.abs(self.upper_m - eye_m))
        return 1.01 * float(np.linalg.norm(farthest)) + 1.0

    @property
    def nbytes(self) -> int:
        """Memory, of the GPU where there is one [bytes]."""
        made = vars(self)
        by_gl = self.by_gl.world.nbytes if "by_gl" in made else 0
        return by_gl + (self.by_loops.tables.nbytes if "by_loops" in made else 0)

    def release(self) -> None:
        if "by_gl" in vars(self):
            self.by_gl.release()


def _bounds(position_m: NDArray[np.float32]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    points = position_m.astype(np.float64) if len(position_m) else np.zeros((1, 3))
    return points.min(axis=0), points.max(axis=0)
