"""The paper's first check of its simulator: variance against intensity of rendered grey bars."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tacos_framework import Plugins, Progress, Settings, UserError, setting
from tacos_framework.camera import gain_factor
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
from tacos_plugins.noise_calibration.frame_files import FrameStack
from tacos_plugins.noise_calibration.measuring import Measured, doubts, measure
from tacos_plugins.noise_calibration.pages import frame_picture, shown
from tacos_plugins.noise_calibration.photon_transfer import ROUNDING_DN2
from tacos_plugins.sensors.calibration import load_calibration
from tacos_report.page import Page, Paragraph, Section, Table, Warnings, in_both_widths, write_page


class CheckedCamera(SimulatedCamera):
    """A camera, the setting it is calibrated at, and those its noise is predicted for."""

    title: str = setting(help="Its name.", min_length=1)
    settings: tuple[CameraSetting, ...] = setting(
        help="The calibrated setting first, then those to predict.", min_length=1
    )
    reference: str = setting(
        "",
        help="Calibration to predict from: a name in the catalogs, or a file; by default what the frames of "
        "the first setting give.",
        is_path=True,
    )


@dataclass(frozen=True, eq=False)
class Checked:
    """Frames of one setting: what was predicted and what they show."""

    setting: CameraSetting
    stack: FrameStack
    measured: tuple[Measured, ...]
    predicted: tuple[tuple[float, float], ...]  # for each channel slope and intercept [DN, DN^2]
    black_level_dn: float
    white_level_dn: float

    def median_error(self, channel: int) -> float:
        """Median over the levels of how far variance is from the prediction, relative to it [1]."""
        measured = self.measured[channel]
        photon_dn, thermal_dn2 = self.predicted[channel]
        used = measured.fit.used
        signal = measured.levels.mean_dn[used] - measured.black_level_dn
        predicted = photon_dn * signal + thermal_dn2 + ROUNDING_DN2
        return float(np.median(np.abs(measured.levels.variance_dn2[used] / predicted - 1)))

    def as_data(self) -> dict[str, Any]:
        channels = {}
        for i, measured in enumerate(self.measured):
            photon_dn, thermal_dn2 = self.predicted[i]
            channels[measured.channel] = {
                **measured.as_data(),
                "predicted": {"photon_dn": photon_dn, "thermal_dn2": thermal_dn2},
                "slope_error": measured.fit.photon_dn / photon_dn - 1,
                "intercept_error_dn2": measured.fit.thermal_dn2 - thermal_dn2,
                "median_variance_error": self.median_error(i),
            }
        return {"setting": self.setting.model_dump(), "channels": channels}


class ValidateNoise:
    """Renders grey bars, takes frames with a sensor model, and holds their noise against the affine model.

    A calibration belongs to one setting. Other settings follow from it by generalisation (paper, eq. 1): the
    slope grows with the gain, the intercept with its square, and the exposure time acts through the signal
    alone. Each camera is checked at its calibrated setting and at others.

    Source: The paper, Sec. 4.1 (Image Statistics) with Fig. 3a, and the supplement's figure on noise model
    generalisation: 30 ms at 15 dB, then 20 ms at 12 dB and 40 ms at 6 dB.
    """

    class Config(Settings):
        bench: NoiseBench = setting(NoiseBench(), help="Target, light and number of frames.")
        cameras: tuple[CheckedCamera, ...] = setting(help="The cameras to check.", min_length=1)
        levels: int = setting(
            64, help="Into how many levels of brightness pixels are gathered.", ge=5, le=4096
        )

    def __init__(self, config: Config) -> None:
        self.config = config

    def run(self, *, out: Path, seed: int, plugins: Plugins, progress: Progress) -> Mapping[str, Any]:
        cameras = self.config.cameras
        progress.phase("taking frames", sum(len(camera.settings) for camera in cameras))
        found = {}
        for camera in cameras:
            found[camera.title] = self._check(camera, seed, plugins, progress)
        write_page(out / "report.html", _page(self.config, found))
        return {
            "cameras": {title: [each.as_data() for each in checked] for title, checked in found.items()},
            "summary": "\n".join(_finding(title, checked) for title, checked in found.items()),
        }

    def _check(
        self, camera: CheckedCamera, seed: int, plugins: Plugins, progress: Progress
    ) -> tuple[Checked, ...]:
        rig = build_rig(camera.rig, plugins)
        sensor = build(camera.sensor, "sensor", plugins)
        calibrated_db = camera.settings[0].gain_db
        reference: Sequence[tuple[float, float]] = ()
        if camera.reference:
            known = load_calibration(camera.reference)
            calibrated_db = known.gain_db
            reference = tuple(zip(known.photon_dn, known.thermal_dn2, strict=True))
        checked = []
        for place, each in enumerate(camera.settings):
            exposure = each.as_exposure()
            capture = capture_of(self.config.bench, rig, exposure, plugins)
            draws = EpisodeDraws(seed, ("validate-noise", camera.title, place))
            stack, batch = take_frames(sensor, capture, exposure, self.config.bench.frames, draws)
            try:
                measured = measure(
                    stack,
                    black_level_dn=batch.black_level_dn,
                    white_level_dn=batch.white_level_dn,
                    levels=self.config.levels,
                )
            except UserError as error:
                error.add_note(f"{camera.title} at {each}")
                raise
            if not reference:
                reference = [(m.fit.photon_dn, m.fit.thermal_dn2) for m in measured]
            ratio = gain_factor(each.gain_db - calibrated_db)
            predicted = tuple((ratio * photon, ratio**2 * thermal) for photon, thermal in reference)
            checked.append(
                Checked(each, stack, measured, predicted, batch.black_level_dn, batch.white_level_dn)
            )
            progress.step(f"{camera.title}, {each}")
        return tuple(checked)


def _finding(title: str, checked: Sequence[Checked]) -> str:
    slopes = [
        m.fit.photon_dn / photon - 1
        for c in checked
        for m, (photon, _) in zip(c.measured, c.predicted, strict=True)
    ]
    errors = [c.median_error(i) for c in checked for i in range(len(c.measured))]
    return (
        f"{title}: slopes within {max(map(abs, slopes)):.1%} of the prediction, variances within "
        f"{max(errors):.1%} (median over levels, worst channel and setting)"
    )


def _rows(checked: Sequence[Checked]) -> tuple[tuple[str, ...], ...]:
    rows = []
    for each in checked:
        for i, measured in enumerate(each.measured):
            photon_dn, thermal_dn2 = each.predicted[i]
            fit = measured.fit
            rows.append(
                (
                    str(each.setting),
                    measured.channel,
                    shown(photon_dn),
                    shown(fit.photon_dn, fit.photon_ci),
                    f"{fit.photon_dn / photon_dn - 1:+.1%}",
                    shown(thermal_dn2),
                    shown(fit.thermal_dn2, fit.thermal_ci),
                    f"{each.median_error(i):.1%}",
                )
            )
    return tuple(rows)


def _page(config: ValidateNoise.Config, found: Mapping[str, Sequence[Checked]]) -> Page:
    bench = config.bench
    sections = [_section(title, checked) for title, checked in found.items()]
    pictures = tuple(
        frame_picture(each.stack, each.black_level_dn, each.white_level_dn, f"{title} at {each.setting}")
        for title, checked in found.items()
        for each in checked[:1]
    )
    return Page(
        eyebrow="Noise validation",
        title=_finding(*next(iter(found.items()))),
        lead=f"{bench.scene.use} at {bench.illumination_lux:g} lux, rendered by {bench.renderer.use}; "
        f"{bench.frames} frames per setting. Lines are predictions, dots what the frames show.",
        sections=[*sections, Section("The target", pictures)],
    )


def _section(title: str, checked: Sequence[Checked]) -> Section:
    panels = [
        (str(each.setting), [m.cloud(*line) for m, line in zip(each.measured, each.predicted, strict=True)])
        for each in checked
    ]
    warnings = [
        f"{each.setting}, {sentence}" for each in checked for sentence in doubts(each.stack, each.measured)
    ]
    heads = (
        "Setting", "Channel", "Slope, predicted", "Slope, found (95 %)", "Error",
        "Intercept, predicted", "Intercept, found (95 %)", "Variance error, median",
    )  # fmt: skip
    return Section(
        title,
        (
            in_both_widths(
                partial(photon_transfer, f"validation-{title}", panels, line="the predicted lines"),
                "Variance over signal at the calibrated setting (first) and at others. Pale dots do not "
                "count: noise cut off at black or white, finer than a digital number, or saturated.",
            ),
            Paragraph(f"{_finding(title, checked)}."),
            Warnings("What the frames say beside that", tuple(warnings)),
            Table(heads, _rows(checked), "Slopes in DN, intercepts in DN², rounding taken off."),
        ),
    )
