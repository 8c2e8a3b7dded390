"""The component: has Blender's Cycles take the pictures of an episode."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, Capture, Episode, Exposure, Rig, Settings, View, World, setting
from tacos_framework.camera import world_from_camera
from tacos_plugins.renderers.blender.child import pictures, refuse_without_blender, workplace
from tacos_plugins.renderers.blender.scene_file import shot, write_scene
from tacos_plugins.renderers.traced.moments import moments_s, world_at
from tacos_plugins.renderers.traced.truth import TracedTruth


class BlenderRenderer:
    """Path tracing with Blender's Cycles on the processor, for a last test of the highest realism.

    Geometry, units and materials are those of `renderer.moderngl` and `renderer.mitsuba`: one unit of
    radiance in Blender stands for 1 cd/m2. A panorama around the world also lights it, where the others light
    by its mean. Lights that no glowing surface shows are not seen, as in `renderer.moderngl`. Depth and ids
    are traced through pixel centres, and are those where things stand in the middle of the exposure.

    Blender runs in a process of its own, one for each batch of frames.

    Source: Blender Foundation, Cycles, as the Python module bpy.
    """

    class Config(Settings):
        """Settings of `renderer.blender`."""

        samples: int = setting(128, help="Paths per pixel.", ge=1, le=1 << 20)
        max_depth: int = setting(
            12, help="Most legs of a path from the camera to a light; 2 is direct light alone.", ge=2, le=128
        )
        denoise: bool = setting(
            False, help="Let Blender denoise pictures of few paths, at the cost of detail."
        )
        motion_samples: int = setting(
            1, help="Poses averaged over the exposure for motion blur; 1 is none.", ge=1, le=256
        )
        near_m: float = setting(0.05, help="Surfaces nearer than this are not seen.", unit="m", gt=0)
        threads: int = setting(
            1, help="Threads of each process; pictures do not depend on it.", ge=1, le=1024
        )
        seed: int = setting(0, help="Seed of the noise.", ge=0)

    def __init__(self, config: Config):
        self._config = config
        self._kept: tuple[str, TracedTruth] | None = None

    def capture(self, episode: Episode, *, rig: Rig, exposure: Exposure) -> Capture:
        """One view per camera of the rig for every frame of the batch.

        Raises `UserError` when bpy is not installed, saying what to do.
        """
        refuse_without_blender()
        with workplace() as folder:
            write_scene(folder, episode.world)
            shots = [
                each
                for n, camera in enumerate(rig.cameras)
                for each in self._shots(episode, camera, n, exposure)
            ]
            config = self._config
            settings = {
                "max_depth": config.max_depth,
                "denoise": config.denoise,
                "near_m": config.near_m,
                "threads": config.threads,
            }
            taken = iter(pictures(folder, shots, settings) if shots else [])
        return Capture(episode, tuple(self._view(episode, camera, taken) for camera in rig.cameras))

    def _truth_of(self, world: World) -> TracedTruth:
        if self._kept is None or self._kept[0] != world.key:
            self._kept = (world.key, TracedTruth(world))
        return self._kept[1]

    def _shots(
        self, episode: Episode, camera: Camera, number: int, exposure: Exposure
    ) -> Iterator[dict[str, object]]:
        """Frame by frame, moment by moment."""
        config = self._config
        count = config.motion_samples
        for frame, middle_s in enumerate(episode.time_s):
            moments = moments_s(float(middle_s), exposure.time_s, count)
            poses = world_from_camera(episode.trajectory.at(moments), camera.agent_from_camera)
            for moment, pose in enumerate(poses):
                entropy = (config.seed, episode.first_frame + frame, number, moment)
                seed = int(np.random.SeedSequence(entropy).generate_state(1)[0] >> 1)
                moved = {
                    m.object_id: m.trajectory.at(moments[moment : moment + 1])[0] for m in episode.movers
                }
                yield shot(camera, pose, moved, samples=-(-config.samples // count), seed=seed)

    def _view(self, episode: Episode, camera: Camera, taken: Iterator[NDArray[np.float32]]) -> View:
        poses = world_from_camera(episode.trajectory.at(episode.time_s), camera.agent_from_camera)
        shape = (len(poses), camera.height_px, camera.width_px)
        luminance = np.zeros((*shape, 3), np.float32)
        depth, object_id = np.empty(shape, np.float32), np.empty(shape, np.int32)
        for frame, pose in enumerate(poses):
            truth = self._truth_of(world_at(episode, float(episode.time_s[frame])))
            depth[frame], object_id[frame] = truth.seen(camera, pose, self._config.near_m)
            for _ in range(self._config.motion_samples):
                luminance[frame] += np.maximum(next(taken), 0) / np.float32(self._config.motion_samples)
        return View(camera, poses, luminance, depth, object_id)
