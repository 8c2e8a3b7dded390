"""The scene `scene.recorded`: a recording of a real camera, as the light that other cameras see."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from tacos_framework import (
    Camera,
    Episode,
    Exposure,
    Fault,
    Lens,
    Object,
    Rig,
    Sensor,
    Settings,
    Trajectory,
    UserError,
    World,
    setting,
)
from tacos_framework.camera import agent_from_camera
from tacos_plugins.rigs.calibration_files import CalibratedLens
from tacos_worlds.recorded.recording import ExposedFrames
from tacos_worlds.recorded.refusals import of_exposure, of_light
from tacos_worlds.recorded.source import REFLECTED, Source
from tacos_worlds.recorded.view import shown_of

CALIBRATION = "camera.yaml"
"""The calibration that a recording's folder may hold."""


@dataclass(frozen=True, eq=False)
class RecordedEpisode(Episode):
    source: Source | None = None
    camera: Camera | None = None
    """What recorded it, at the resolution of its light, mounted as the settings say."""
    exposure_name: str = ""  # of which exposure its frames are
    first_index: int = 0  # where in the recording the episode begins
    cd_m2_per_unit: float = 1.0  # luminance of one unit of its light [cd/m2 per DN/ms]


class RecordedScene:
    """Frames of a camera in use, in place of a simulated world.

    Candidates see its light with their own pixels, field of view, exposure, gain, noise, lens and pipeline.
    A recording can only be degraded: views beyond its own, finer detail, shorter exposures than its blur,
    less noise and brighter highlights are refused, each with its reason. The noise it carries is not added
    again.

    Its light has no unit. The scenario's illuminance gives it one: its mean is the luminance of a surface
    that reflects 18 %.

    Every episode is a stretch of its own of the recording, which is one world.
    """

    one_world: ClassVar[bool] = True
    absent: ClassVar[tuple[str, ...]] = ("geometry", "poses", "depth", "objects")

    class Config(Settings):
        recording: str = setting(
            "recording", help="Folder of the frames, with times.csv.", min_length=1, is_path=True
        )
        response: Literal["recorded", "linear", "estimated"] = setting(
            "recorded",
            help="That of response.txt where there is one, else estimated from several exposures; linear "
            "for raw samples.",
        )
        mosaic: Literal["auto", "RG", "GR", "BG", "GB", "none"] = setting(
            "auto",
            help="Colour filters by OpenCV's names; auto sees whether there are any and where green is, and "
            "takes RG or GR.",
        )
        bit_depth: int | None = setting(
            None, help="Bits per sample; by default what the samples reach.", unit="bit", ge=8, le=16
        )
        calibration: CalibratedLens | None = setting(
            None,
            help="Calibration of its camera; by default camera.yaml in the folder, where there is one.",
            is_path=True,
        )
        hfov_deg: float | None = setting(
            None, help="Horizontal field of view, where there is no calibration.", unit="deg", gt=0, lt=180
        )
        pitch_deg: float = setting(0.0, help="Tilt of the camera, positive is up.", unit="deg", ge=-90, le=90)
        black_level_dn: float = setting(0.0, help="Pedestal in its linear samples.", unit="DN", ge=0)
        vignetting: tuple[float, float, float] = setting(
            (0.0, 0.0, 0.0),
            help="Its fall-off, which is undone: 1 + k1 r^2 + k2 r^4 + k3 r^6 with r 1 in the corner.",
        )
        mean_luminance_cd_m2: float | None = setting(
            None, help="Mean luminance of its light, where it was measured.", unit="cd/m2", gt=0
        )
        exposure_ms: float | None = setting(
            None,
            help="The exposure whose frames are shown; by default the longest that clips less than 1 %.",
            unit="ms",
            gt=0,
        )
        frames: int = setting(5, help="Consecutive frames of an episode.", ge=1)

    def __init__(self, config: Config) -> None:
        self.config = config
        self._source, self._camera = _opened(config.model_copy(update={"frames": 1}))
        self._stretches()

    @cached_property
    def _frames(self) -> ExposedFrames:
        exposures = self._source.recording.exposures.values()
        if self.config.exposure_ms is None:
            return self._source.exposure_for(math.inf)
        for each in exposures:
            if math.isclose(each.exposure_ms, self.config.exposure_ms, rel_tol=1e-3):
                return each
        known = ", ".join(each.name for each in exposures)
        raise UserError(
            Fault(
                "exposure_ms",
                f"the recording has none of {self.config.exposure_ms:g} ms",
                f"one of {known} ms",
            )
        )

    def _stretches(self) -> int:
        recorded = len(self._frames.stamp_s)
        if recorded < self.config.frames:
            what = f"has {recorded} frames of {self._frames.name} ms"
            raise UserError(
                Fault(self.config.recording, what, f"{self.config.frames} or more, as frames: says")
            )
        return recorded // self.config.frames

    @property
    def remarks(self) -> tuple[str, ...]:
        count, frames, shown = self._stretches(), self.config.frames, self._frames
        stretches = f"{count} stretch{'es' * (count > 1)}"
        signal_dn = self._source.mean * shown.exposure_ms
        slope_dn = self._source.noise(shown.name).slope_dn
        electrons = (
            f"{signal_dn / slope_dn:.0f} electrons" if slope_dn > 0 else "more electrons than noise tells"
        )
        return (
            f"{self._source.recording.response_from} Its {shown.name} ms frames are shown.",
            f"By its noise, a recorded sample holds {electrons} on average. The illuminance of the scenario "
            "should give a camera like the one that recorded as many.",
            f"The recording has {stretches} of {frames} frames: more scenes than that see the same frames "
            "again, so that intervals come out too narrow.",
        )

    def episode(self, *, rng: np.random.Generator, illumination_lux: float) -> RecordedEpisode:
        frames, stretch = self.config.frames, int(rng.integers(self._stretches()))
        first = stretch * frames
        middle_s = [self._source.middle_s(self._frames.name, first + i) for i in range(frames)]
        return RecordedEpisode(
            world=World(
                f"recorded {self.config.recording}",
                (),
                (),
                (Object("background", "background"),),
                ("background",),
            ),
            trajectory=Trajectory(np.array([min(middle_s[0], 0.0) - 1.0]), np.eye(4)[None]),
            time_s=np.array(middle_s),
            walk=np.zeros(frames, np.int32),
            absent=self.absent,
            source=self._source,
            camera=self._camera,
            exposure_name=self._frames.name,
            first_index=first,
            cd_m2_per_unit=self._cd_m2_per_unit(illumination_lux),
        )

    def not_shown(
        self, rig: Rig, *, exposure: Exposure, sensors: Sequence[Sensor], illumination_lux: float
    ) -> Mapping[str, str]:
        reasons: dict[str, str] = {}
        for camera in rig.cameras:
            reasons |= shown_of(camera, self._camera, rig.cameras[0].agent_from_camera[:3, 3])
            reasons |= of_exposure(self._source, self._frames, exposure, camera, self._camera)
            for sensor in sensors:
                per_unit = self._cd_m2_per_unit(illumination_lux)
                reasons |= of_light(
                    self._source, self._frames, per_unit, sensor, camera, exposure, self._camera
                )
        return reasons

    def _cd_m2_per_unit(self, illumination_lux: float) -> float:
        mean_cd_m2 = self.config.mean_luminance_cd_m2 or REFLECTED * illumination_lux / math.pi
        return mean_cd_m2 / self._source.mean


@lru_cache(maxsize=2)
def _opened(config: RecordedScene.Config) -> tuple[Source, Camera]:
    """Light and camera of a recording, read once for all candidates."""
    from tacos_worlds.recorded.reader import read_recording

    recording = read_recording(
        config.recording, fewest=1, response=config.response, bit_depth=config.bit_depth
    )
    mosaic = recording.mosaic if config.mosaic == "auto" else config.mosaic
    cell = 1 if mosaic == "none" else 2
    height, width = next(iter(recording.exposures.values())).codes_dn.shape[1:]
    lens, focal_px, centre_px = _optics(config, width, height)
    camera = Camera(
        "recorded",
        width // cell,
        height // cell,
        pixel_um=1.0,
        focal_length_mm=focal_px / cell * 1e-3,
        principal_point_px=((centre_px[0] + 0.5) / cell - 0.5, (centre_px[1] + 0.5) / cell - 0.5),
        agent_from_camera=agent_from_camera((0.0, 0.0, 0.0), pitch_deg=config.pitch_deg),
        lens=lens,
    )
    source = Source(recording, cell, mosaic in ("RG", "GR"), config.black_level_dn, _fall_off(config, camera))
    return source, camera


def _optics(config: RecordedScene.Config, width: int, height: int) -> tuple[Lens, float, tuple[float, float]]:
    """Projection, focal length and principal point of the whole image [px, px]."""
    calibration = config.calibration
    if calibration is None and (file := Path(config.recording) / CALIBRATION).is_file():
        calibration = CalibratedLens.model_validate(str(file))
    if calibration is not None:
        if (calibration.width_px, calibration.height_px) != (width, height):
            what = f"is of {calibration.width_px} x {calibration.height_px} px"
            raise UserError(Fault(calibration.title, what, f"{width} x {height} px, as the frames"))
        return calibration.lens, calibration.focal_length_px, calibration.centre_px
    if config.hfov_deg is None:
        raise UserError(
            Fault(
                config.recording,
                f"the field of view of its camera is unknown: there is no {CALIBRATION} and no hfov_deg",
                "one of the two",
                "State hfov_deg as its data sheet does, or calibrate it.",
            )
        )
    focal_px = width / 2 / math.tan(math.radians(config.hfov_deg / 2))
    return Lens(), focal_px, ((width - 1) / 2, (height - 1) / 2)


def _fall_off(config: RecordedScene.Config, camera: Camera) -> NDArray[np.float32] | None:
    """(H, W) share of the light that its lens passes; None where nothing is known of it."""
    if not any(config.vignetting):
        return None
    x, y = np.meshgrid(np.arange(camera.width_px), np.arange(camera.height_px))
    corner = np.hypot(camera.width_px / 2, camera.height_px / 2)
    square = ((x - camera.centre_px[0]) ** 2 + (y - camera.centre_px[1]) ** 2) / corner**2
    k1, k2, k3 = config.vignetting
    return np.asarray(1 + square * (k1 + square * (k2 + square * k3)), np.float32)
