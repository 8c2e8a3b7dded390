"""The component: streams an episode's frames through the GPU."""

from __future__ import annotations

import logging
from collections import OrderedDict
from functools import lru_cache
from time import perf_counter
from typing import ClassVar

import moderngl
import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera.geometry import world_from_camera
from tacos_framework.settings import Settings, setting
from tacos_framework.values import Camera, Capture, Episode, Exposure, Rig, View, World
from tacos_plugins.renderers.moderngl.context import gl_context
from tacos_plugins.renderers.moderngl.flatten import SurfaceKind
from tacos_plugins.renderers.moderngl.gpu_world import GpuWorld
from tacos_plugins.renderers.moderngl.lit_mesh import LitMesh, light_world
from tacos_plugins.renderers.moderngl.painter import Painter, Programs
from tacos_plugins.renderers.moderngl.probes import FACE_PX, look_around, nearest_visible, probe_places
from tacos_plugins.renderers.moderngl.targets import TargetPool

log = logging.getLogger(__name__)

_WORLDS_KEPT = 2
_PROBE_NEAR_M = 0.02


class ModernglRenderer:
    """Headless OpenGL rasterizer with baked light.

    Geometry is that of a pinhole camera. Surfaces reflect baked direct and indirect light as Lambertian
    plus, where they are metallic or smoother than roughness 0.8, GGX highlights and reflections. A
    dielectric of roughness 0.8 or more is exactly Lambertian: reflectance r under illuminance E has the
    luminance ``E r / pi``.
    """

    class Config(Settings):
        """Settings of `renderer.moderngl`."""

        samples: int = setting(4, help="Colour samples per pixel against aliasing; 1 is none.", ge=1, le=16)
        motion_samples: int = setting(
            1, help="Poses averaged over the exposure for motion blur; 1 is none.", ge=1, le=256
        )
        near_m: float = setting(0.05, help="Surfaces nearer than this are not drawn.", unit="m", gt=0)
        light_texel_m: float = setting(
            0.05, help="Distance of light map texels on large flat surfaces.", unit="m", ge=0.005
        )

    reads: ClassVar[frozenset[str]] = frozenset(
        {
            "width_px",
            "height_px",
            "pixel_um",
            "binning",
            "focal_length_mm",
            "principal_point_px",
            "agent_from_camera",
            "time_s",
        }
    )

    def __init__(self, config: Config):
        self._config = config

    def capture(self, episode: Episode, *, rig: Rig, exposure: Exposure) -> Capture:
        """One view per camera of the rig for every frame of the batch."""
        device = _device()
        painter = device.painter(episode.world, self._config.light_texel_m)
        return Capture(
            episode,
            tuple(self._view(device, painter, episode, camera, exposure) for camera in rig.cameras),
        )

    def _view(
        self, device: _Device, painter: Painter, episode: Episode, camera: Camera, exposure: Exposure
    ) -> View:
        size = (camera.width_px, camera.height_px)
        shape = (len(episode), camera.height_px, camera.width_px)
        targets = device.targets.get(size, min(self._config.samples, device.context.max_samples))
        near_m = self._config.near_m
        poses = world_from_camera(episode.trajectory.at(episode.time_s), camera.agent_from_camera)
        luminance = np.empty((*shape, 3), np.float32)
        depth = np.empty(shape, np.float32)
        object_id = np.empty(shape, np.int32)
        truth = np.empty((*shape[1:], 2), np.float32)
        glimpse = np.empty((*shape[1:], 3), np.float32)
        for frame, pose in enumerate(poses):
            painter.truth(camera, pose, near_m, targets)
            targets.read_truth(truth)
            depth[frame], object_id[frame] = truth[..., 0], truth[..., 1]
            moments = self._poses_during(episode, frame, camera, exposure)
            for number, moment in enumerate(moments):
                painter.colour(camera, moment, near_m, targets)
                targets.read_colour(glimpse)
                if number:
                    luminance[frame] += glimpse
                else:
                    luminance[frame] = glimpse
            luminance[frame] *= np.float32(1 / len(moments))
        return View(camera, poses, luminance, depth, object_id)

    def _poses_during(
        self, episode: Episode, frame: int, camera: Camera, exposure: Exposure
    ) -> NDArray[np.float64]:
        """(M, 4, 4) camera poses spread evenly over a frame's exposure [m]."""
        count = self._config.motion_samples
        offsets = ((np.arange(count) + 0.5) / count - 0.5) * exposure.time_s
        agent = episode.trajectory.at(episode.time_s[frame] + offsets)
        return world_from_camera(agent, camera.agent_from_camera)


class _Device:
    """What lives as long as the process: shaders, framebuffers and the worlds used last."""

    def __init__(self, context: moderngl.Context):
        self.context = context
        self.targets = TargetPool(context)
        self._programs = Programs(context)
        self._painters: OrderedDict[tuple[str, float], Painter] = OrderedDict()

    def painter(self, world: World, texel_m: float) -> Painter:
        """The painter of a world, lit and uploaded on first use."""
        key = (world.key, texel_m)
        if key not in self._painters:
            while len(self._painters) >= _WORLDS_KEPT:
                self._painters.popitem(last=False)[1].release()
            start = perf_counter()
            self._painters[key] = self._prepare(world, texel_m)
            log.info("lit and uploaded %d triangles in %.1f s", world.triangle_count, perf_counter() - start)
        self._painters.move_to_end(key)
        return self._painters[key]

    def _prepare(self, world: World, texel_m: float) -> Painter:
        lit = light_world(world, _indirect_lux(world), texel_m)
        painter = Painter(self._programs, GpuWorld(self.context, world, lit))
        if np.any(lit.chunks.kind & SurfaceKind.GLOSSY):
            self._add_probes(painter, world, lit)
        return painter

    def _add_probes(self, painter: Painter, world: World, lit: LitMesh) -> None:
        targets = self.targets.get((FACE_PX, FACE_PX), 1)

        def view(
            camera: Camera, pose: NDArray[np.float64]
        ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
            luminance = np.empty((FACE_PX, FACE_PX, 3), np.float32)
            truth = np.empty((FACE_PX, FACE_PX, 2), np.float32)
            painter.colour(camera, pose, _PROBE_NEAR_M, targets)
            targets.read_colour(luminance)
            painter.truth(camera, pose, _PROBE_NEAR_M, targets)
            targets.read_truth(truth)
            return luminance, truth[..., 0]

        places = probe_places(world, lit.tracer)
        probes = [look_around(place, world.lights, view) for place in places]
        above = lit.mesh.position_m + np.float32(0.05) * lit.mesh.normal
        painter.world.set_probes(probes, nearest_visible(places, above, lit.tracer))


@lru_cache(maxsize=1)
def _device_of(context: moderngl.Context) -> _Device:
    context.enable(moderngl.DEPTH_TEST)
    return _Device(context)


def _device() -> _Device:
    return _device_of(gl_context())


def _indirect_lux(world: World) -> tuple[NDArray[np.float32], ...]:
    if world.indirect_lux is not None:
        return world.indirect_lux
    from tacos_framework.lighting import bake_indirect  # traces rays: only where it is needed

    return bake_indirect(world)
