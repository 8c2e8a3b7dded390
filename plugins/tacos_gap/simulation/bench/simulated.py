"""Captures from our simulator: what it expects, and what a camera with further effects would give."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import (
    CandidateFailed,
    Exposure,
    Fault,
    ImageContext,
    ImageGeometry,
    Plugins,
    Rig,
    Use,
    UserError,
    generator,
    signature_of,
)
from tacos_framework import Capture as Rendered
from tacos_framework.camera import image_velocity
from tacos_framework.formation import (
    EpisodeDraws,
    ImageFormation,
    PlacedEffect,
    PlacedSensor,
    SensorAt,
    captured,
)
from tacos_gap.captures import Board, Noise, RealCapture
from tacos_gap.simulation.bench.fine_pictures import drawn_finer
from tacos_gap.simulation.bench.light import dimmed, patches_of, repeated, velocity_of, without_world
from tacos_gap.simulation.bench.settings import BenchSettings, BenchShot
from tacos_gap.simulation.sensors import NODE, response_of
from tacos_plugins.building import build, build_rig, episode_of, part_of

REFERENCE_LUX = 1000.0
"""Light that scenes are rendered under before the lamp is dimmed to the level that is asked for [lux]."""

BRIGHTEST_PERCENT = 99.0
"""Percentile of the signal that is called its brightest places."""


@dataclass(frozen=True, eq=False)
class Expected:
    """Expectation of the simulator for a shot."""

    light: Rendered  # what was rendered, dimmed to the level
    factor: float  # by which the lamp was dimmed to that level [1]
    signal_dn: NDArray[np.float32]
    """(1 or N, H, W, C) noise-free values of the file with the pedestal, not clipped [DN]."""
    black_level_dn: float
    white_level_dn: float


class CaptureBench:
    """A camera on a bench. Raises UserError when a component is not there or its settings are wrong."""

    def __init__(self, settings: BenchSettings, plugins: Plugins, seed: int = 0):
        self.settings = settings
        self.shots = {shot.id: shot for shot in settings.shots()}
        self._plugins = plugins
        self._seed = seed
        self._camera = build_rig(settings.rig, plugins).cameras[0]
        self._rig = Rig((self._camera,))
        self._renderer = build(settings.renderer, "renderer", plugins)
        self._reality = settings.reality and build(settings.reality, "renderer", plugins)
        self._sensor = PlacedSensor(settings.sensor.use, NODE, build(settings.sensor, "sensor", plugins))
        parts = [part_of(use, "effect", plugins) for use in settings.effects]
        self._effects = [PlacedEffect(part.use, part.use, part.cls, part.config) for part in parts]
        self._rendered: dict[str, Rendered] = {}

    def captures(self) -> Iterator[RealCapture]:
        for shot in self.shots.values():
            yield self.capture(shot)

    def capture(self, shot: BenchShot) -> RealCapture:
        expected = self.expected(shot)
        light = self._real_light(shot, expected)
        light = light if shot.kind == "sequence" else repeated(light, shot.frames)
        draws = EpisodeDraws(self._seed, ("bench", shot.id))
        formation = ImageFormation(self._exposure(shot), self._effects)
        batch = formation.expose(formation.light(light, draws), self._sensor, draws)
        return RealCapture(
            id=shot.id,
            kind=shot.kind,
            real_dn=batch.images[0].astype(np.float32),
            expected_dn=None if shot.kind == "board" else expected.signal_dn,
            valid=np.ones(expected.signal_dn.shape[1:3], bool),
            geometry=ImageGeometry.of_camera(self._camera),
            context=self._context(shot, expected),
            noise=self._noise,
            group=shot.group,
            level_uncertainty=shot.level_uncertainty,
            board=self._board(shot) if shot.kind == "board" else None,
            edge_angle_deg=self._edge_angle_deg(shot) if shot.kind == "edge" else None,
            patches=patches_of(expected.light, expected.signal_dn) if shot.kind == "chart" else None,
        )

    def expected(self, shot: BenchShot) -> Expected:
        light = self._light(shot)
        sensor = self._sensor_at(self._exposure(shot))
        black, white = float(sensor.sensor.black_level_dn), float(sensor.sensor.white_level_dn)
        samples = _known(sensor, light.views[0].luminance_cd_m2)
        above = samples - np.float32(black)
        factor = 0.0
        if shot.scene is not None:
            brightest = float(np.percentile(above, BRIGHTEST_PERCENT))
            if brightest <= 0:
                raise UserError(Fault(shot.id, f"{shot.scene.use} is black", "a scene that reflects light"))
            factor = shot.level * (white - black) / brightest
        _, dark_dn = response_of(sensor, above.shape[-1])
        samples = above * np.float32(factor) + (black + dark_dn).astype(np.float32)
        return Expected(dimmed(light, factor), factor, samples, black, white)

    # one shot ---------------------------------------------------------------------------------------------

    def _exposure(self, shot: BenchShot) -> Exposure:
        return Exposure(shot.exposure_ms * 1e-3, self.settings.f_number, self.settings.gain_db)

    def _sensor_at(self, exposure: Exposure) -> SensorAt:
        return SensorAt(self._sensor.use, NODE, self._sensor.at(self._camera.name), self._camera, exposure)

    @cached_property
    def _noise(self) -> Noise:
        """Of the sensor at the shortest time: what dark current adds to the noise is least there."""
        shortest = min(self.shots.values(), key=lambda shot: shot.exposure_ms)
        sensor = self._sensor_at(self._exposure(shortest))
        channels = _known(sensor, np.zeros((1, 1, 1, 3), np.float32)).shape[-1]
        return response_of(sensor, channels)[0]

    def _light(self, shot: BenchShot) -> Rendered:
        if shot.scene is None:
            size = (1, self._camera.height_px, self._camera.width_px, 3)
            return without_world(self._camera, np.zeros(size, np.float32))
        timed = "exposure" in _asked_for_by(self._renderer)
        key = f"{shot.scene!r} {self._rendered_frames(shot)} {shot.exposure_ms if timed else 0}"
        if key not in self._rendered:
            self._rendered = {key: self._render(shot, self._renderer)}
        return self._rendered[key]

    def _real_light(self, shot: BenchShot, expected: Expected) -> Rendered:
        if shot.scene is None or self._reality is None or not expected.light.episode.world.lights:
            return expected.light
        return dimmed(self._render(shot, self._reality), expected.factor)

    @staticmethod
    def _rendered_frames(shot: BenchShot) -> int:
        return shot.frames if shot.kind == "sequence" else 1

    def _render(self, shot: BenchShot, renderer: Any) -> Rendered:
        assert shot.scene is not None
        frames = self._rendered_frames(shot)
        use = shot.scene
        if shot.kind == "sequence":
            use = Use(use=use.use, **{**use.settings, "frames": frames})
        scene = build(use, "scene", self._plugins)
        episode = episode_of(
            scene, rng=generator(self._seed, "bench", use.use), illumination_lux=REFERENCE_LUX
        )
        if len(episode) < frames:
            raise UserError(
                Fault(shot.id, f"{use.use} gives {len(episode)} frames", f"at least {frames}, as asked")
            )
        asked, exposure = _asked_for_by(renderer), self._exposure(shot)

        def take(*, rig: Rig) -> Rendered:
            wanted = {
                name: value for name, value in {"rig": rig, "exposure": exposure}.items() if name in asked
            }
            rendered: Rendered = renderer.capture(episode[:frames], **wanted)
            return rendered

        return captured(renderer, self._rig, partial(drawn_finer, take) if shot.kind == "board" else take)

    def _context(self, shot: BenchShot, expected: Expected) -> ImageContext:
        view = expected.light.views[0]
        exposure = self._exposure(shot)
        context = ImageContext(
            exposure_s=exposure.time_s,
            gain_db=exposure.gain_db,
            f_number=exposure.f_number,
            black_level_dn=expected.black_level_dn,
            white_level_dn=expected.white_level_dn,
        )
        if shot.kind in ("edge", "chart", "scene", "sequence"):
            context = replace(context, depth_m=view.depth_m[0])
        if shot.kind == "sequence":
            times_s = expected.light.episode.time_s
            context = replace(
                context,
                velocity_px_s=velocity_of(image_velocity(view, expected.light.episode)),
                frame_interval_s=float(np.diff(times_s).mean()) if len(times_s) > 1 else None,
                reference_row=(self._camera.height_px - 1) / 2,
            )
        return context

    def _board(self, shot: BenchShot) -> Board:
        config = self._scene_config(shot)
        try:
            return Board(tuple(config.inner_corners), float(config.square_mm))
        except AttributeError:
            assert shot.scene is not None
            raise UserError(
                Fault(shot.id, f"{shot.scene.use} is no board", "a scene with inner_corners and square_mm")
            ) from None

    def _edge_angle_deg(self, shot: BenchShot) -> float | None:
        angle = getattr(self._scene_config(shot), "angle_deg", None)
        return None if angle is None else float(angle)

    def _scene_config(self, shot: BenchShot) -> Any:
        assert shot.scene is not None
        return part_of(shot.scene, "scene", self._plugins).config


def _asked_for_by(renderer: Any) -> tuple[str, ...]:
    return tuple(signature_of(type(renderer), "renderer").supplied)


def _known(sensor: SensorAt, light_cd_m2: NDArray[np.float32]) -> NDArray[np.float32]:
    """Expectation of a sensor for light; in a sentence where it knows too little of the camera."""
    try:
        return sensor.expect(light_cd_m2)
    except CandidateFailed as failed:
        remedy = "Give the missing figures as settings of the sensor."
        raise UserError(Fault("sensor", str(failed), "", remedy)) from failed
