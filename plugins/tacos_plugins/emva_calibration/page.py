"""The data sheet as a page."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from tacos_plugins.emva_calibration.data_sheet import NAMES, DataSheet
from tacos_plugins.emva_calibration.evaluation import signals
from tacos_plugins.emva_calibration.figure import linearity_drawing, signal_to_noise, transfer
from tacos_plugins.noise_calibration.pages import shown
from tacos_report.page import Code, Page, Paragraph, Section, Table, Warnings, in_both_widths


def page(title: str, sheets: Sequence[DataSheet], frames: int, doubts: Sequence[str], settings: str) -> Page:
    """The page of a calibration, green or mono drawn."""
    sheet = sheets[0]
    _, light = signals(sheet.brights, sheet.darks, sheet.selected)
    drawn = [
        in_both_widths(
            partial(transfer, sheet),
            "Photon transfer. Each dot is a level; pale ones are no part of the fit, which reaches "
            "to 70 % of "
            "saturation.",
        ),
        in_both_widths(partial(signal_to_noise, sheet), "Signal-to-noise ratio."),
    ]
    if np.isfinite(light).all():
        caption = "Linearity. Deviations are relative to the line, for 5 to 95 % of saturation."
        drawn.append(in_both_widths(partial(linearity_drawing, sheet), caption))
    heads = ("Figure", "Unit", *(each.channel.name for each in sheets))
    rows = tuple(
        (words, unit, *(_cell(each, name) for each in sheets)) for name, (words, unit) in NAMES.items()
    )
    depth = sheet.channel.bit_depth
    return Page(
        eyebrow="Data sheet by EMVA 1288, Release 4.0 Linear",
        title=title,
        lead=f"From {frames} frames of {depth} bits: {len(sheet.brights.mean_dn)} levels of light and "
        f"{len(sheet.darks.mean_dn)} of darkness. In brackets stand intervals of 95 %; the error of the "
        "measured photons is not in them.",
        sections=[
            Section(
                "Data sheet",
                (Warnings("Before you rely on this", tuple(doubts)), Table(heads, rows, row_heads=True)),
            ),
            Section("Measurements", tuple(drawn)),
            Section(
                "For a simulation",
                (Paragraph("sensor.yaml, settings of the electron sensor of a recipe:"), Code(settings)),
            ),
        ],
    )


def _cell(sheet: DataSheet, name: str) -> str:
    figure = sheet.figures[name]
    if figure.value is None:
        return f"not known: {figure.reason}"
    return ("at most " if figure.reason else "") + shown(figure.value, figure.ci)
