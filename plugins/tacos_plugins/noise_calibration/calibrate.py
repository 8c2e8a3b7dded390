"""From grey-bar frames to an affine noise calibration (paper, supplement, Noise Model Calibration)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import model_validator

from tacos_framework import Plugins, Progress, Settings, setting, to_yaml
from tacos_framework.camera import exposure_per_luminance, gain_factor
from tacos_framework.formation import EpisodeDraws
from tacos_plugins.building import build, build_rig
from tacos_plugins.noise_calibration.bench import (
    CameraSetting,
    NoiseBench,
    SimulatedCamera,
    capture_of,
    take_frames,
)
from tacos_plugins.noise_calibration.figure import photon_transfer
from tacos_plugins.noise_calibration.frame_files import FrameStack, Mosaic, read_stack
from tacos_plugins.noise_calibration.measuring import Measured, doubts, measure
from tacos_plugins.noise_calibration.pages import frame_picture, shown
from tacos_plugins.sensors.calibration import Calibration, load_calibration
from tacos_report.page import Code, Page, Section, Table, Warnings, in_both_widths, write_page

WHITE_WALL_DN_SHARE = 200 / 255
"""Signal where brightness is not known: a white wall at 20 lux, f/2, 30 ms and 5 dB, over full scale [1]."""


class FilmedCamera(Settings):
    """Facts of a camera that its frames on disk do not state."""

    sensor: str = setting("unknown", help="The image sensor.")
    pixel_um: float = setting(help="Pitch of its photosites.", unit="um", gt=0)
    exposure_ms: float = setting(help="Exposure time.", unit="ms", gt=0)
    gain_db: float = setting(help="Gain.", unit="dB")
    bit_depth: int = setting(help="Bits per sample, right-aligned in the files.", unit="bit", ge=1, le=16)
    black_level_dn: float = setting(0.0, help="Pedestal in the files.", unit="DN", ge=0)
    cfa: Mosaic = setting("none", help="Bayer mosaic of the files, read from the top left.")
    responsivity_dn_per_lux_s: float | None = setting(
        None,
        help="Signal per focal-plane exposure, if measured; by default images are as bright as the paper's.",
        unit="DN/(lux s)",
        gt=0,
    )


class Rendering(SimulatedCamera):
    """A simulated camera that takes the frames."""

    exposure: CameraSetting = setting(help="Exposure of the target.")
    bench: NoiseBench = setting(NoiseBench(), help="Target, light and number of frames.")


class CalibrateNoise:
    """Fits ``variance = photon_dn * signal + thermal_dn2`` to frames of grey bars, channel by channel.

    Frames are those of one static scene with fixed settings, from a folder, or rendered. The calibration is
    written as ``calibration.yaml``, which `sensor.affine-noise` takes as its ``calibration``; the report
    shows the photon transfer, what the line leaves over, and what speaks against it.

    Source: `tacos_plugins.noise_calibration.photon_transfer`.
    """

    class Config(Settings):
        frames: str = setting(
            "", help="Folder or glob of the frames (PNG, TIFF, npy); empty to render them.", is_path=True
        )
        camera: FilmedCamera | None = setting(None, help="The camera that took the frames.")
        rendering: Rendering | None = setting(None, help="Rendering of the frames, where none are given.")
        levels: int = setting(
            64, help="Into how many levels of brightness pixels are gathered.", ge=5, le=4096
        )
        title: str = setting("", help="Name of the calibration; by default the sensor and its setting.")

        @model_validator(mode="after")
        def _frames_from_somewhere(self) -> CalibrateNoise.Config:
            if self.frames and self.camera is None:
                raise ValueError(
                    "frames also take camera: {pixel_um: ..., exposure_ms: ..., gain_db: ..., bit_depth: ...}"
                )
            if not self.frames and self.rendering is None:
                raise ValueError("either frames: (a folder) with camera:, or rendering:")
            return self

    def __init__(self, config: Config) -> None:
        self.config = config

    def run(self, *, out: Path, seed: int, plugins: Plugins, progress: Progress) -> Mapping[str, Any]:
        """Calibrate; leaves ``calibration.yaml`` and ``report.html``."""
        progress.phase("calibrating", 2)
        stack, camera, truth = self._frames(seed, plugins)
        progress.step(f"{stack.frames} frames")
        white_level_dn = 2**camera.bit_depth - 1
        channels = measure(
            stack,
            black_level_dn=camera.black_level_dn,
            white_level_dn=white_level_dn,
            levels=self.config.levels,
        )
        warnings = doubts(stack, channels)
        path = out / "calibration.yaml"
        calibration = self._calibration(camera, channels, stack)
        path.write_text(_as_yaml(calibration), encoding="utf-8")
        load_calibration(path)  # it must serve as an input from now on
        rows = _rows(channels, truth)
        write_page(out / "report.html", _page(calibration, stack, channels, camera, warnings, rows))
        progress.step("fitted")
        return {
            "calibration": path.name,
            "frames": stack.frames,
            "channels": {measured.channel: measured.as_data() for measured in channels},
            "warnings": warnings,
            "summary": "\n".join(
                [
                    *(
                        f"{channel}: photon {photon}, thermal {thermal}"
                        for channel, photon, thermal, *_ in rows
                    ),
                    *warnings,
                    f"To use it: --set nodes.NODE.calibration={path}",
                ]
            ),
        }

    def _frames(self, seed: int, plugins: Plugins) -> tuple[FrameStack, FilmedCamera, Calibration | None]:
        """The frames, what is known of their camera, and the noise that went in where that is known."""
        config = self.config
        if config.frames and config.camera is not None:
            camera = config.camera
            return read_stack(config.frames, camera.cfa, camera.bit_depth), camera, None
        if config.rendering is None:
            raise ValueError("no frames and no rendering; Config refuses that")
        rendering = config.rendering
        exposure = rendering.exposure.as_exposure()
        rig = build_rig(rendering.rig, plugins)
        sensor = build(rendering.sensor, "sensor", plugins)
        capture = capture_of(rendering.bench, rig, exposure, plugins)
        draws = EpisodeDraws(seed, ("calibrate-noise", "frames"))
        stack, batch = take_frames(sensor, capture, exposure, rendering.bench.frames, draws)
        known: Calibration | None = getattr(sensor, "calibration", None)
        camera = FilmedCamera(
            sensor=rig.cameras[0].electrons.sensor,
            pixel_um=rig.cameras[0].pixel_um * rig.cameras[0].binning,
            exposure_ms=rendering.exposure.exposure_ms,
            gain_db=rendering.exposure.gain_db,
            bit_depth=round(batch.white_level_dn + 1).bit_length() - 1,
            black_level_dn=batch.black_level_dn,
        )
        return stack, camera, known

    def _calibration(
        self, camera: FilmedCamera, channels: Sequence[Measured], stack: FrameStack
    ) -> Calibration:
        setting_words = f"{camera.exposure_ms:g} ms and {camera.gain_db:g} dB, {camera.bit_depth} bit"
        notes = [
            f"95 % intervals: {m.channel} photon_dn {m.fit.photon_ci[0]:.4g} to {m.fit.photon_ci[1]:.4g}, "
            f"thermal_dn2 {m.fit.thermal_ci[0]:.4g} to {m.fit.thermal_ci[1]:.4g}."
            for m in channels
        ]
        responsivity = camera.responsivity_dn_per_lux_s
        if responsivity is None:
            responsivity = assumed_responsivity(camera.gain_db, camera.bit_depth)
            notes.append(
                "The responsivity is chosen, not measured: a white wall (reflectance 0.8) at 20 lux, f/2, "
                "30 ms and 5 dB comes to 200/255 of full scale."
            )
        return Calibration(
            title=self.config.title or f"{camera.sensor} at {setting_words}",
            source=f"procedure.calibrate-noise: {stack.frames} frames of grey bars, {stack.source}; variance "
            "over time, weighted straight line, rounding taken off.",
            sensor=camera.sensor,
            pixel_um=camera.pixel_um,
            exposure_ms=camera.exposure_ms,
            gain_db=camera.gain_db,
            bit_depth=camera.bit_depth,
            photon_dn=tuple(round(max(m.fit.photon_dn, 0.0), 6) for m in channels),
            thermal_dn2=tuple(round(max(m.fit.thermal_dn2, 0.0), 6) for m in channels),
            responsivity_dn_per_lux_s=round(responsivity, 4),
            notes=tuple(notes),
        )


def assumed_responsivity(gain_db: float, bit_depth: int) -> float:
    """Responsivity at a gain that makes images as bright as with the shipped calibration [DN/(lux s)].

    >>> round(assumed_responsivity(15.0, 8), 1)  # that of flea3_imx172
    21081.9
    """
    white_wall_cd_m2 = 20.0 * 0.8 / math.pi  # matte, lit by 20 lux
    exposure_lux_s = white_wall_cd_m2 * exposure_per_luminance(0.030, 2.0)
    return WHITE_WALL_DN_SHARE * (2**bit_depth - 1) / (exposure_lux_s * gain_factor(5.0 - gain_db))


def _as_yaml(calibration: Calibration) -> str:
    data = {name: list(value) if isinstance(value, tuple) else value for name, value in calibration}
    return to_yaml(data)


def _rows(channels: Sequence[Measured], truth: Calibration | None) -> list[tuple[str, ...]]:
    """Channel, both figures with intervals, levels, misfit, and what went in where it is known."""
    rows: list[tuple[str, ...]] = []
    for i, measured in enumerate(channels):
        fit = measured.fit
        went_in = f"{truth.photon_dn[i]:g} DN, {truth.thermal_dn2[i]:g} DN²" if truth else ""
        rows.append(
            (
                measured.channel,
                f"{shown(fit.photon_dn, fit.photon_ci)} DN",
                f"{shown(fit.thermal_dn2, fit.thermal_ci)} DN²",
                f"{fit.used.sum()} of {len(fit.used)}",
                f"{fit.misfit:.2f}",
                went_in,
            )
        )
    return rows


def _page(
    calibration: Calibration,
    stack: FrameStack,
    channels: Sequence[Measured],
    camera: FilmedCamera,
    warnings: Sequence[str],
    rows: Sequence[tuple[str, ...]],
) -> Page:
    clouds = [m.cloud(m.fit.photon_dn, m.fit.thermal_dn2) for m in channels]
    slopes = ", ".join(f"{m.channel} {m.fit.photon_dn:.3g}" for m in channels)
    heads = ("Channel", "photon_dn (95 %)", "thermal_dn2 (95 %)", "Levels used", "Reduced χ²", "Went in")
    return Page(
        eyebrow=f"Noise calibration: {calibration.title}",
        title=f"Variance grows with the signal by {slopes} DN",
        lead=f"From {stack.frames} frames of one scene. Variance is that over time, pixel by pixel; the line "
        "is fitted by weighted least squares, and 1/12 DN² of rounding is taken off.",
        sections=[
            Section(
                "Photon transfer",
                (
                    Warnings("Before you rely on this", tuple(warnings)),
                    in_both_widths(
                        partial(
                            photon_transfer,
                            "calibration",
                            [(calibration.title, clouds)],
                            line="the fitted line",
                        ),
                        "Each dot is a level of brightness with two standard errors; pale dots are left out "
                        "(noise cut off at black or white, finer than a digital number, or saturated).",
                    ),
                    Table(heads, tuple(rows)),
                ),
            ),
            Section(
                "The frames",
                (
                    frame_picture(
                        stack,
                        camera.black_level_dn,
                        2**camera.bit_depth - 1,
                        "The first frame, for a display.",
                    ),
                ),
            ),
            Section("The calibration", (Code(_as_yaml(calibration)),)),
        ],
    )
