"""The renderer `renderer.recorded`: what cameras see of a recording."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from tacos_framework import Camera, CandidateFailed, Capture, Exposure, Rig, Settings, View
from tacos_worlds.recorded.scene import RecordedEpisode
from tacos_worlds.recorded.view import shares_of


class RecordedLight:
    """Light of a recording on the pixels of other cameras, and the noise that it carries.

    Exposures longer than the recorded ones are means along the path of each pixel.
    """

    draws_lenses: ClassVar[bool] = True
    averages_exposure: ClassVar[bool] = True

    class Config(Settings):
        """It has no settings."""

    def __init__(self, config: Config) -> None:
        self.config = config

    def capture(self, episode: RecordedEpisode, *, rig: Rig, exposure: Exposure) -> Capture:
        """One view per camera; depth and objects are unknown, which the episode says."""
        return Capture(episode, tuple(_view(episode, camera, exposure) for camera in rig.cameras))


def _view(episode: RecordedEpisode, camera: Camera, exposure: Exposure) -> View:
    source, recorded = episode.source, episode.camera
    assert source is not None
    assert recorded is not None
    shares = shares_of(camera, recorded)
    size = (camera.height_px, camera.width_px)
    lights, noises = [], []
    for i in range(len(episode)):
        index = episode.first_index + episode.first_frame + i
        light = source.light(episode.exposure_name, index, exposure.time_s * 1e3)
        noise = source.variance(episode.exposure_name, light)
        seen = (shares.light @ light.reshape(-1, source.channels)).reshape(*size, -1)
        carried = (shares.noise @ noise.reshape(-1, source.channels)).reshape(*size, -1)
        lights.append(np.broadcast_to(np.maximum(seen, 0) * episode.cd_m2_per_unit, (*size, 3)))
        noises.append(carried * episode.cd_m2_per_unit**2)
    if not np.isfinite(lights).all():
        raise CandidateFailed(f"the recording gives camera {camera.name} light that is no number")
    frames = (len(episode), *size)
    return View(
        camera,
        np.tile(camera.agent_from_camera, (len(episode), 1, 1)),
        np.asarray(lights, np.float32),
        np.full(frames, np.inf, np.float32),
        np.zeros(frames, np.int32),
        np.asarray(noises, np.float32),
    )
