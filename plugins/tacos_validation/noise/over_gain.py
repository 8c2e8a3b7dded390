"""Models of noise over gain, held against real cameras: each gain is predicted from the others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from tacos_framework import Fault, Plugins, Progress, Settings, UserError, setting
from tacos_report.figures.canvas import NARROW_IN, draw, light_grid
from tacos_report.page import Page, Paragraph, Section, Table, in_both_widths, write_page
from tacos_report.palette import camera_colour
from tacos_validation.noise.gain_models import MODELS
from tacos_validation.noise.gain_table import MeasuredCamera, read_gain_table
from tacos_validation.noise.two_stage_noise import Noise

SIGNAL = 0.02
"""Signal at which variances are compared, over full scale: read and photon noise both bear on it [1]."""

_TWO_SIDED_90 = 1.645
_NEAR = 0.25
TITLES = {
    "affine": "Affine (eq. 1)",
    "electrons": "Electrons (EMVA 1288)",
    "two-stages": "Before and after the gain",
}


@dataclass(frozen=True)
class LeftOut:
    """One setting that was left out: its measured noise and the prediction of each model."""

    slope: float  # measured a over full scale [1]
    intercept: float  # measured b over full scale [1]
    predicted: Mapping[str, Noise]

    @property
    def variance(self) -> float:
        """Measured variance at `SIGNAL`; not above 0 where a profile's line fails in the dark [1]."""
        return self.slope * SIGNAL + self.intercept


class NoiseOverGainCheck:
    """Leaves each gain of each camera out, and predicts its noise from the camera's other gains.

    A gain cannot be predicted where no other gain of its camera has an intercept above 0; it is counted in
    ``left_out`` and in no figure. A measured intercept at or below 0 has no logarithm: it counts in the
    variance alone, as a miss where that variance is not above 0 either.

    Source: `tacos_validation.noise.two_stage_noise`; the paper, eq. 1; EMVA Standard 1288, Release 4.0, eq.
    13.
    """

    class Config(Settings):
        data: str = setting(
            "", help="CSV file with the columns maker, model, iso, a, b: variance = a x + b.", is_path=True
        )

    def __init__(self, config: Config) -> None:
        self.config = config

    def run(self, *, out: Path, seed: int, plugins: Plugins, progress: Progress) -> Mapping[str, Any]:
        if not self.config.data:
            raise UserError(
                Fault(
                    "procedure.noise-over-gain",
                    "data is empty",
                    "a CSV file with the columns maker, model, iso, a, b",
                    "Name one: --set data=FILE.csv",
                )
            )
        cameras = read_gain_table(Path(self.config.data))
        progress.phase("predicting", len(cameras))
        settings: list[LeftOut] = []
        for camera in cameras:
            settings += left_out_gains(camera)
            progress.step(camera.name)
        if not settings:
            raise UserError(
                Fault(
                    self.config.data,
                    "no camera has two gains with slopes and an intercept above 0",
                    "cameras that were measured at two gains or more",
                )
            )
        models = {name: figures_of(settings, name) for name in MODELS}
        measured = sum(len(camera) for camera in cameras)
        write_page(out / "report.html", _page(len(cameras), settings, models))
        return {
            "cameras": len(cameras),
            "settings": len(settings),
            "left_out": measured - len(settings),
            "models": models,
            "summary": "\n".join(
                f"{TITLES[name]}: intercept {m['intercept_rms_log2']:.2f} log2 rms, variance at 2 % within "
                f"25 % in {m['within_25_percent_at_2_percent_signal']:.0%} of settings, 90 % intervals hold "
                f"{m['coverage_90']:.0%}"
                for name, m in models.items()
            ),
        }


def left_out_gains(camera: MeasuredCamera) -> Iterator[LeftOut]:
    usable = camera.slopes > 0
    camera = MeasuredCamera(
        camera.name, camera.gains[usable], camera.slopes[usable], camera.intercepts[usable]
    )
    for gain in np.unique(camera.gains):
        others = camera.without_gain(gain)
        if not (others.intercepts > 0).any():
            continue
        predicted = {name: fit(others)(float(gain)) for name, fit in MODELS.items()}
        for i in np.flatnonzero(camera.gains == gain):
            yield LeftOut(float(camera.slopes[i]), float(camera.intercepts[i]), predicted)


def figures_of(settings: Sequence[LeftOut], model: str) -> dict[str, float]:
    """Figures of a model for ``result.json``; shares are over all settings."""
    ratios = [_variance_ratio(s, model) for s in settings]
    held = [
        abs(np.log(ratio)) <= _TWO_SIDED_90 * s.predicted[model].variance_sd(SIGNAL)
        for ratio, s in zip(ratios, settings, strict=True)
    ]
    return {
        "intercept_rms_log2": float(np.sqrt(np.mean(_intercept_errors(settings, model) ** 2))),
        "within_25_percent_at_2_percent_signal": float(np.mean([abs(r - 1) <= _NEAR for r in ratios])),
        "coverage_90": float(np.mean(held)),
    }


def _variance_ratio(setting: LeftOut, model: str) -> float:
    """Predicted over measured variance; infinite where the measured one is not above 0."""
    predicted = setting.predicted[model].variance(SIGNAL)
    return predicted / setting.variance if setting.variance > 0 else float("inf")


def _intercept_errors(settings: Sequence[LeftOut], model: str) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Predicted over measured intercepts, where the measured are above 0 [log2]."""
    dark = [s for s in settings if s.intercept > 0]
    return np.array([np.log2(s.predicted[model].intercept / s.intercept) for s in dark])


def _page(cameras: int, settings: Sequence[LeftOut], models: Mapping[str, Mapping[str, float]]) -> Page:
    best = min(models, key=lambda name: models[name]["intercept_rms_log2"])
    rows = tuple(
        (
            TITLES[name],
            f"{m['intercept_rms_log2']:.2f}",
            f"{m['within_25_percent_at_2_percent_signal']:.0%}",
            f"{m['coverage_90']:.0%}",
        )
        for name, m in models.items()
    )
    heads = ("Model", "Intercept, rms [log2]", "Variance at 2 % within 25 %", "90 % intervals hold")
    return Page(
        eyebrow="Noise over gain",
        title=f"{TITLES[best]}: intercepts within {models[best]['intercept_rms_log2']:.2f} log2 rms",
        lead=f"{len(settings)} settings of {cameras} cameras. Each gain is left out and predicted from the "
        "other gains of its camera.",
        sections=[
            Section(
                "Predictions",
                (
                    Table(heads, rows, row_heads=True),
                    in_both_widths(
                        partial(_errors_drawn, settings),
                        "Share of settings whose intercept is predicted within a factor.",
                    ),
                    Paragraph(
                        "Intercepts at or below 0 are left out of the first column. A setting whose variance "
                        "at 2 % is not above 0 counts as a miss in the others."
                    ),
                ),
            )
        ],
    )


def _errors_drawn(settings: Sequence[LeftOut], *, narrow: bool = False) -> str:
    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        for i, name in enumerate(MODELS):
            errors = np.sort(np.abs(_intercept_errors(settings, name)))
            shares = np.arange(1, len(errors) + 1) / len(errors)
            axes.plot(errors, shares, color=camera_colour(i), label=TITLES[name])
        axes.set_xlim(0, 4)
        axes.set_ylim(0, 1)
        axes.set_xlabel("error of the intercept [log2]")
        axes.set_ylabel("share of settings [1]")
        light_grid(axes, "y")
        axes.legend(loc="lower right")

    width = NARROW_IN if narrow else 7.0
    name = "noise-over-gain-narrow" if narrow else "noise-over-gain"
    return draw(
        name, (width, 4.0), "Share of settings over the error of the intercept, one curve per model.", paint
    )
