"""A camera's figures by EMVA 1288 from a folder of frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tacos_files.camera_images import read_frame
from tacos_framework import Progress, Settings, UserError, setting
from tacos_plugins.emva_calibration.data_sheet import DataSheet, data_sheet
from tacos_plugins.emva_calibration.doubts import doubts, of_mosaic
from tacos_plugins.emva_calibration.export import sensor_settings, sensor_yaml
from tacos_plugins.emva_calibration.frame_table import FrameGroup, FrameTable, read_frame_table
from tacos_plugins.emva_calibration.measurement import faults_of_files, measure_channels
from tacos_plugins.emva_calibration.page import page
from tacos_plugins.noise_calibration.frame_files import Mosaic
from tacos_plugins.noise_calibration.pages import shown
from tacos_plugins.sensors.emva import Emva
from tacos_report.page import write_page

_MAIN = ("system_gain_dn_per_e", "quantum_efficiency", "dark_noise_e")


class CalibrateCamera:
    """Measures a camera by EMVA 1288, Release 4.0 Linear, from pairs of frames of even light and of darkness.

    The folder holds frames as the sensor gave them and ``frames.csv`` with the columns kind (bright or dark),
    exposure_ns, photons_per_pixel (empty where it is not known) and file: two frames of each level at least.
    Groups of eight or more serve for PRNU and DSNU. Of a Bayer mosaic each colour is measured; the figures at
    the top of ``result.json`` are those of green.
    """

    class Config(Settings):
        frames: str = setting(help="Folder of the frames and frames.csv.", is_path=True, min_length=1)
        cfa: Mosaic = setting("none", help="Bayer mosaic of the frames, read from the top left.")
        bit_depth: int | None = setting(
            None, help="Bits per sample; by default what the samples reach.", unit="bit", ge=1, le=16
        )
        title: str = setting("", help="Name of the camera; by default that of the folder.")

    def __init__(self, config: Config) -> None:
        self.config = config

    def run(self, *, out: Path, seed: int, progress: Progress) -> Mapping[str, Any]:
        """Calibrate; leaves ``sensor.yaml`` and ``report.html``."""
        config, folder = self.config, Path(self.config.frames)
        table = read_frame_table(folder)
        groups = table.groups
        if table.faults:
            raise UserError([*table.faults, *faults_of_files(folder, groups, config.cfa)])
        progress.phase("reading frames", len(groups))
        channels, single = measure_channels(folder, groups, config.cfa, config.bit_depth, progress.step)
        rng = np.random.default_rng(seed)
        sheets = [data_sheet(channel, config.frames, rng) for channel in channels]
        found = self._doubts(folder, table, single, sheets)
        settings, missing = sensor_settings(sheets)
        # They must serve as an input from now on.
        Emva(Emva.Config(**{name: value for name, value in settings.items() if name != "use"}))
        text = sensor_yaml(settings, missing)
        (out / "sensor.yaml").write_text(text, encoding="utf-8")
        frames = sum(len(group.files) for group in groups)
        title = config.title or folder.resolve().name
        write_page(out / "report.html", page(title, sheets, frames, found, text))
        return _result(sheets, frames, found)

    def _doubts(
        self,
        folder: Path,
        table: FrameTable,
        single: Sequence[FrameGroup],
        sheets: Sequence[DataSheet],
    ) -> list[str]:
        several = len(sheets) > 1
        found = [
            f"{sheet.channel.name}: {sentence}" if several else sentence
            for sheet in sheets
            for sentence in doubts(sheet)
        ]
        if single:
            found.append(
                f"{len(single)} levels have one frame and are left out ({single[0]}, ...): take two of each."
            )
        if sheets[0].channel.bytes_swapped:
            found.append(
                "the two bytes of a sample stand in the wrong order in the files, and were swapped: as "
                "stored, neighbouring pixels differ at random. Save frames in the byte order of their format."
            )
        if table.unread and not np.isfinite(sheets[0].brights.photons).all():
            found.append(f"columns of frames.csv that are not read: {', '.join(table.unread)}.")
        if not several:
            found += _mosaic_doubt(sheets[0], folder)
        return found


def _mosaic_doubt(sheet: DataSheet, folder: Path) -> list[str]:
    """Look at the brightest level that is not saturated for a mosaic that was not named."""
    levels = sorted(sheet.channel.of("bright"), key=lambda each: each[1].mean_dn)
    count = int(np.flatnonzero(sheet.selected.fitted)[-1]) + 1
    path = levels[min(count, len(levels)) - 1][0].files[0]
    stored = read_frame(path, str(path), folder)[..., 0]
    image = (stored.byteswap() if sheet.channel.bytes_swapped else stored) / sheet.channel.step_dn
    means = np.array([[image[row::2, column::2].mean() for column in (0, 1)] for row in (0, 1)])
    return of_mosaic(means, sheet.value("black_level_dn") or 0.0)


def _result(sheets: Sequence[DataSheet], frames: int, found: Sequence[str]) -> dict[str, Any]:
    sheet = sheets[0]
    figures = {each.channel.name: {k: f.as_data() for k, f in each.figures.items()} for each in sheets}
    lines = []
    for name in _MAIN:
        figure = sheet.figures[name]
        told = f"not known: {figure.reason}" if figure.value is None else shown(figure.value, figure.ci)
        lines.append(f"{name}: {told}")
    return {
        **figures[sheet.channel.name],
        "bit_depth": sheet.channel.bit_depth,
        "channel": sheet.channel.name,
        "channels": figures if len(sheets) > 1 else {},
        "frames": frames,
        "doubts": list(found),
        "levels": _levels(sheet),
        "sensor": "sensor.yaml",
        "summary": "\n".join([*lines, *found]),
    }


def _levels(sheet: DataSheet) -> list[dict[str, Any]]:
    brights = sheet.brights
    return [
        {
            "exposure_s": float(brights.exposure_s[i]),
            "photons": float(brights.photons[i]) if np.isfinite(brights.photons[i]) else None,
            "mean_dn": float(brights.mean_dn[i]),
            "variance_dn2": float(brights.variance_dn2[i]),
            "used": bool(sheet.selected.fitted[i]),
        }
        for i in range(len(brights.mean_dn))
    ]
