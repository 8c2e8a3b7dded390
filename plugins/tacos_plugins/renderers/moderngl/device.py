"""Objects that live as long as the process: shaders, framebuffers, and the worlds used last."""

from __future__ import annotations

import logging
from functools import lru_cache
from time import perf_counter

import moderngl
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, LRUCache, World
from tacos_plugins.renderers.light.baked_mesh import BakedMesh, light_world
from tacos_plugins.renderers.light.flatten import SurfaceKind
from tacos_plugins.renderers.light.probe_map import ProbeMap, map_probes
from tacos_plugins.renderers.light.probes import Probe, look_around, probe_places
from tacos_plugins.renderers.moderngl.context import describe_gl, gl_context
from tacos_plugins.renderers.moderngl.drawn_world import DrawnWorld
from tacos_plugins.renderers.moderngl.gl_drawing import Programs
from tacos_plugins.renderers.moderngl.kept_light import kept
from tacos_plugins.renderers.moderngl.painter import Painter
from tacos_plugins.renderers.moderngl.panorama import FaceStore
from tacos_plugins.renderers.moderngl.rendered_views import EdgeBlending
from tacos_plugins.renderers.moderngl.targets import TargetPool
from tacos_plugins.renderers.software.pixel_batch import PixelBatch

log = logging.getLogger(__name__)

_MOST_WORLDS = 1000  # memory is what bounds them
_PROBE_NEAR_M = 0.02


class Device:
    """Renders worlds with one context, each lit and uploaded on first use."""

    def __init__(self, context: moderngl.Context):
        context.enable(moderngl.DEPTH_TEST)
        context.front_face = "cw"  # images are rendered first row first, which mirrors windings
        self.targets = TargetPool(context)
        self.is_software = describe_gl().is_software
        self.most_samples = context.max_samples
        self.context = context
        self._programs = Programs(context)
        self._batches = (PixelBatch(), PixelBatch())
        self.faces = FaceStore(0)
        self.painters: LRUCache[Painter] = LRUCache(
            _MOST_WORLDS, bytes_of=lambda painter: painter.world.nbytes, let_go=Painter.release
        )

    def painter(self, world: World, texel_m: float) -> Painter:
        """The painter of a world.

        `texel_m`: distance of light map texels [m].
        """
        return self.painters.get((world.key, texel_m), lambda: self._prepare(world, texel_m))

    def blending_edges(self, camera: Camera, near_m: float) -> EdgeBlending:
        """The photographer that blends edges: by loops where OpenGL is software."""
        return EdgeBlending(self.targets, camera, near_m, by_loops=self.is_software)

    def _prepare(self, world: World, texel_m: float) -> Painter:
        start = perf_counter()

        def light() -> BakedMesh:
            log.info("lighting %d triangles every %g m, once for this world", world.triangle_count, texel_m)
            return light_world(world, _indirect_lux(world), texel_m)

        lit = kept("light", world, texel_m, light)
        painter = Painter(DrawnWorld(self._programs, self._batches, world, lit))
        if np.any(lit.chunks.kind & SurfaceKind.GLOSSY):
            around = kept("probes", world, texel_m, lambda: self._look_around(painter, world, lit))
            painter.world.mirror(*around)
        if not self.is_software:
            painter.world.upload()
        log.info("lit and uploaded %d triangles in %.1f s", world.triangle_count, perf_counter() - start)
        return painter

    def _look_around(
        self, painter: Painter, world: World, lit: BakedMesh
    ) -> tuple[tuple[Probe, ...], ProbeMap]:
        """Surroundings for glossy surfaces to mirror, and the part that each place mirrors."""

        def view(
            camera: Camera, pose: NDArray[np.float64]
        ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
            picture = self.blending_edges(camera, _PROBE_NEAR_M).take(painter, pose)
            return picture.luminance_cd_m2, picture.depth_m

        places = probe_places(world, lit.tracer)
        probes = tuple(look_around(place, world.lights, view) for place in places)
        bounds = painter.world.lower_m, painter.world.upper_m
        return probes, map_probes(places, *bounds, lit.tracer)


def device() -> Device:
    """The device of this process, made on first use; raises as `gl_context` does."""
    return _device_of(gl_context())


@lru_cache(maxsize=1)
def _device_of(context: moderngl.Context) -> Device:
    return Device(context)


def _indirect_lux(world: World) -> tuple[NDArray[np.float32], ...]:
    if world.indirect_lux is not None:
        return world.indirect_lux
    from tacos_plugins.lighting import bake_indirect  # traces rays: only where it is needed

    return bake_indirect(world)
