"""The component: takes the pictures of an episode."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, Capture, Episode, Exposure, Rig, Settings, View, World, setting
from tacos_framework.camera import world_from_camera
from tacos_plugins.renderers.moderngl.culling import looked_up
from tacos_plugins.renderers.moderngl.device import Device, device
from tacos_plugins.renderers.moderngl.painter import Painter
from tacos_plugins.renderers.moderngl.panorama import cube_camera
from tacos_plugins.renderers.moderngl.rendered_views import Multisampling, Photographer, RenderedView
from tacos_plugins.renderers.moderngl.resample import Resampling

Number = TypeVar("Number", np.float32, np.int32)

Shot = tuple[Painter, NDArray[np.float64]]
"""Painter of the world at a moment, and the (4, 4) camera pose then [m]."""


class ModernglRenderer:
    """Headless OpenGL rasterizer with baked light.

    Geometry is that of a pinhole camera. Surfaces reflect baked direct and indirect light as Lambertian
    plus, where they are metallic or smoother than roughness 0.8, GGX highlights and reflections. A
    dielectric of roughness 0.8 or more is exactly Lambertian: reflectance r under illuminance E has the
    luminance ``E r / pi``.

    Frames in batches, memory flat in their number::

        renderer = ModernglRenderer(ModernglRenderer.Config())
        for start in range(0, len(episode), 8):
            capture = renderer.capture(episode[start : start + 8], rig=rig, exposure=exposure)
    """

    class Config(Settings):
        """Settings of `renderer.moderngl`."""

        antialiasing: Literal["auto", "multisampling", "edges", "none"] = setting(
            "auto",
            help="Average of colour over a pixel: several samples (multisampling), one sample blended "
            "where surfaces meet (edges), or none; auto is edges, so that GPUs give what software does.",
        )
        samples: int = setting(8, help="Colour samples per pixel for multisampling.", ge=2, le=32)
        motion_samples: int = setting(
            1, help="Poses averaged over the exposure for motion blur; 1 is none.", ge=1, le=256
        )
        near_m: float = setting(0.05, help="Surfaces nearer than this are not drawn.", unit="m", gt=0)
        light_texel_m: float = setting(
            0.06, help="Distance of light map texels on large flat surfaces.", unit="m", ge=0.005
        )

        read_back: Literal["auto", "direct", "buffered"] = setting(
            "auto",
            help="Frames are fetched as they are done (direct), or through pixel buffers while the next is "
            "drawn (buffered, with multisampling or no antialiasing); auto is buffered on GPUs.",
        )
        worlds_memory_mb: int = setting(
            2048,
            help="Memory in each process for worlds kept lit; a house of 15 x 15 m takes about 220 MB.",
            unit="MB",
            ge=1,
        )
        reuse: Literal["off", "cube-map"] = setting(
            "off",
            help="Keep what is seen from each place in all directions (cube-map) and take from it the "
            "pictures of all cameras put there whose pixels are no finer; off draws each picture.",
        )
        reuse_face_px: int = setting(
            1024, help="Pixels across each of the six faces of a cube map.", unit="px", ge=64, le=8192
        )
        reuse_memory_mb: int = setting(
            2048, help="Memory for cube maps in each process; those used longest ago go.", unit="MB", ge=64
        )

    def __init__(self, config: Config):
        self._config = config

    @property
    def averages_exposure(self) -> bool:
        """True if light is that of several moments of the exposure."""
        return self._config.motion_samples > 1

    def capture(self, episode: Episode, *, rig: Rig, exposure: Exposure) -> Capture:
        """One view per camera of the rig for every frame of the batch.

        Raises `UserError` when there is no OpenGL, saying what to install.
        """
        used = device()
        used.painters.most_bytes = self._config.worlds_memory_mb * 10**6
        used.faces.most_bytes = self._config.reuse_memory_mb * 10**6
        painter = used.painter(_as_lit(episode.world), self._config.light_texel_m)
        return Capture(
            episode, tuple(self._view(used, painter, episode, camera, exposure) for camera in rig.cameras)
        )

    def _view(
        self, used: Device, painter: Painter, episode: Episode, camera: Camera, exposure: Exposure
    ) -> View:
        photographer = self._photographer(used, camera)
        if self._config.reuse == "cube-map" and not episode.movers:  # a cube map shows one moment
            photographer = self._resampling(used, _as_lit(episode.world).key, camera, photographer)
        shots = _shots(painter, episode, camera, episode.time_s)
        size = (camera.height_px, camera.width_px)
        luminance, depth, object_id = [], [], []
        for frame, picture in enumerate(self._pictures(used, photographer, shots)):
            depth.append(picture.depth_m)
            object_id.append(looked_up(painter.world.object_of_surface, picture.surface))
            if self._config.motion_samples > 1:
                during_s = episode.time_s[frame] + self._offsets_s(exposure)
                luminance.append(_mean_light(photographer, _shots(painter, episode, camera, during_s), size))
            else:
                luminance.append(picture.luminance_cd_m2)
        poses = np.array([pose for _, pose in shots]).reshape(-1, 4, 4)
        return View(
            camera,
            poses,
            _scaled(_stacked(luminance, (*size, 3), np.float32), episode.world.light_factor),
            _stacked(depth, size, np.float32),
            _stacked(object_id, size, np.int32),
        )

    def _pictures(
        self, used: Device, photographer: Photographer, shots: Sequence[Shot]
    ) -> Iterator[RenderedView]:
        """Pictures one after the other, read while the next is drawn where that is faster."""
        way = self._config.read_back
        ahead = way == "buffered" or (way == "auto" and not used.is_software)
        if ahead and isinstance(photographer, Multisampling):
            return photographer.take_all(shots)
        return (photographer.take(painter, pose) for painter, pose in shots)

    def _resampling(self, used: Device, world_key: str, camera: Camera, direct: Photographer) -> Photographer:
        config = self._config
        return Resampling(
            used.faces,
            (world_key, config.light_texel_m, config.near_m, config.antialiasing, config.samples),
            camera,
            config.reuse_face_px,
            of_faces=self._photographer(used, cube_camera(config.reuse_face_px)),
            direct=direct,
        )

    def _photographer(self, used: Device, camera: Camera) -> Photographer:
        config = self._config
        method = config.antialiasing
        if method in ("auto", "edges"):
            return used.blending_edges(camera, config.near_m)
        samples = min(config.samples, used.most_samples) if method == "multisampling" else 1
        return Multisampling(used.targets, camera, config.near_m, samples)

    def _offsets_s(self, exposure: Exposure) -> NDArray[np.float64]:
        """(M,) moments spread evenly over an exposure, from its middle [s]."""
        count = self._config.motion_samples
        return np.asarray(((np.arange(count) + 0.5) / count - 0.5) * exposure.time_s)


def _as_lit(world: World) -> World:
    """The world whose light is worked out: that of all worlds alike but for how strong it is."""
    return world.unscaled or world


def _scaled(luminance: NDArray[np.float32], factor: float) -> NDArray[np.float32]:
    return luminance if factor == 1 else luminance * np.float32(factor)


def _mean_light(
    photographer: Photographer, shots: Sequence[Shot], size: tuple[int, int]
) -> NDArray[np.float32]:
    """(H, W, 3) mean luminance of several shots [cd/m2]."""
    total = np.zeros((*size, 3), np.float32)
    for painter, pose in shots:
        total += photographer.take(painter, pose).luminance_cd_m2
    total *= np.float32(1 / len(shots))
    return total


def _stacked(
    frames: Sequence[NDArray[Number]], shape: tuple[int, ...], dtype: type[Number]
) -> NDArray[Number]:
    """(N, ...) frames together; one alone is not copied, as at many megapixels copying is what costs."""
    if len(frames) == 1:
        return frames[0][None]
    return np.stack(frames) if frames else np.empty((0, *shape), dtype)


def _shots(painter: Painter, episode: Episode, camera: Camera, time_s: NDArray[np.float64]) -> list[Shot]:
    """Painter and camera pose at each moment; the painters differ where something moves."""
    poses = world_from_camera(episode.trajectory.at(time_s), camera.agent_from_camera)
    if not episode.movers:
        return [(painter, pose) for pose in poses]
    ways = {mover.object_id: mover.trajectory.at(time_s) for mover in episode.movers}
    return [
        (painter.with_moved({object_id: way[number] for object_id, way in ways.items()}), pose)
        for number, pose in enumerate(poses)
    ]
