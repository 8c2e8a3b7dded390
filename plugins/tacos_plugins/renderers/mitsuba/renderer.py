"""The component: traces the pictures of an episode path by path."""

from __future__ import annotations

from types import ModuleType
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from tacos_framework import Camera, Capture, Episode, Exposure, Rig, Settings, View, World, setting
from tacos_framework.camera import world_from_camera
from tacos_plugins.renderers.mitsuba.library import Backend, mitsuba_for
from tacos_plugins.renderers.mitsuba.passes import in_passes, is_power_of_four, samples_per_pose
from tacos_plugins.renderers.mitsuba.pinhole import sensor
from tacos_plugins.renderers.mitsuba.traced_world import TracedWorld
from tacos_plugins.renderers.traced.moments import moments_s, world_at

_PATHS_AT_ONCE = 1 << 22
"""Paths of one pass where Mitsuba traces many at once; bounds memory."""


class MitsubaRenderer:
    """Path tracing with Mitsuba 3: slow, and right to within its noise.

    The reference for `renderer.moderngl`, with its geometry, units and materials. Light is not baked but
    traced, with all reflections, for every picture. Where things move, the world is translated anew for each
    moment, and they cast their shadows there. Surfaces that glow light the world. A light that no
    surface shows is a black surface of its own, which is seen (`renderer.moderngl` draws none), though not in
    depth and ids.

    Noise falls with the square root of `samples`, and faster where paths are spread evenly (`sampler`). It is
    drawn from `seed` and the frame's number in the episode, so a frame comes out the same however an episode
    is cut.

    Source: Jakob, W., et al. (2022). Mitsuba 3 renderer.
    """

    class Config(Settings):
        """Settings of `renderer.mitsuba`."""

        samples: int = setting(64, help="Paths per pixel.", ge=1, le=1 << 20)
        max_depth: int = setting(
            12, help="Most legs of a path from the camera to a light; 2 is direct light alone.", ge=2, le=128
        )
        motion_samples: int = setting(
            1, help="Poses averaged over the exposure for motion blur; 1 is none.", ge=1, le=256
        )
        near_m: float = setting(0.05, help="Surfaces nearer than this are not seen.", unit="m", gt=0)
        backend: Backend = setting(
            "scalar",
            help="Backend: scalar (any processor), llvm (faster, needs LLVM 19 or later), or cuda.",
        )
        seed: int = setting(0, help="Seed of the noise.", ge=0)
        sampler: Literal["independent", "low-discrepancy"] = setting(
            "independent",
            help="Distribution of paths over a pixel and its lights: independent, or even, which has "
            "less noise for twice the time; samples are then a power of four.",
        )

        @model_validator(mode="after")
        def _spreads_evenly(self) -> MitsubaRenderer.Config:
            paths = samples_per_pose(self.samples, self.motion_samples)
            if self.sampler == "low-discrepancy" and not is_power_of_four(paths):
                raise ValueError(
                    f"the sampler low-discrepancy takes 1, 4, 16, 64, ... samples for each pose, not {paths}"
                )
            return self

    def __init__(self, config: Config):
        self._config = config
        self._kept: tuple[str, TracedWorld] | None = None

    @property
    def averages_exposure(self) -> bool:
        """True if light is that of several moments of the exposure."""
        return self._config.motion_samples > 1

    def capture(self, episode: Episode, *, rig: Rig, exposure: Exposure) -> Capture:
        """One view per camera of the rig for every frame of the batch.

        Raises `UserError` when Mitsuba is not installed or its backend does not work here, saying what to do.
        """
        mitsuba = mitsuba_for(self._config.backend)
        views = (
            self._view(mitsuba, episode, camera, number, exposure)
            for number, camera in enumerate(rig.cameras)
        )
        return Capture(episode, tuple(views))

    def _translated(self, mitsuba: ModuleType, world: World) -> TracedWorld:
        if self._kept is None or self._kept[0] != world.key:
            self._kept = (world.key, TracedWorld(mitsuba, world))
        return self._kept[1]

    def _view(
        self, mitsuba: ModuleType, episode: Episode, camera: Camera, number: int, exposure: Exposure
    ) -> View:
        config = self._config
        poses = world_from_camera(episode.trajectory.at(episode.time_s), camera.agent_from_camera)
        shape = (len(poses), camera.height_px, camera.width_px)
        luminance = np.zeros((*shape, 3), np.float32)
        depth = np.empty(shape, np.float32)
        object_id = np.empty(shape, np.int32)
        for frame, pose in enumerate(poses):
            middle_s = float(episode.time_s[frame])
            truth = self._translated(mitsuba, world_at(episode, middle_s)).truth
            depth[frame], object_id[frame] = truth.seen(camera, pose, config.near_m)
            moments = moments_s(middle_s, exposure.time_s, config.motion_samples)
            samples = samples_per_pose(config.samples, config.motion_samples)
            during = world_from_camera(episode.trajectory.at(moments), camera.agent_from_camera)
            for moment, at in enumerate(during):
                noise = np.random.SeedSequence((config.seed, episode.first_frame + frame, number, moment))
                seen = sensor(mitsuba, camera, at, config.near_m)
                traced = self._translated(mitsuba, world_at(episode, float(moments[moment])))
                luminance[frame] += self._traced(mitsuba, traced, seen, samples, noise)
            luminance[frame] /= np.float32(len(moments))
        return View(camera, poses, luminance, depth, object_id)

    def _traced(
        self,
        mitsuba: ModuleType,
        traced: TracedWorld,
        seen: dict[str, Any],
        samples: int,
        noise: np.random.SeedSequence,
    ) -> NDArray[np.float64]:
        """(H, W, 3) luminance through a sensor [cd/m2], the mean of passes that fit into memory."""
        integrator = mitsuba.load_dict({"type": "path", "max_depth": self._config.max_depth})
        even = self._config.sampler == "low-discrepancy"
        through = mitsuba.load_dict({**seen, "sampler": {"type": "ldsampler" if even else "independent"}})
        height, width = seen["film"]["height"], seen["film"]["width"]
        most = max(_PATHS_AT_ONCE // (width * height), 1)
        if even and self._config.backend == "scalar":
            most = samples  # traced one by one, so memory does not grow, and spread evenly over all
        passes = in_passes(samples, most, even=even)
        total = np.zeros((height, width, 3))
        for paths, seed in zip(passes, noise.generate_state(len(passes)), strict=True):
            picture = mitsuba.render(
                traced.scene, sensor=through, integrator=integrator, spp=paths, seed=int(seed)
            )
            total += paths * np.asarray(picture, np.float64)
        return np.maximum(total / samples, 0.0)
