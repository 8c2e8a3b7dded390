"""The report of a camera in use."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from tacos_gap.in_use.diagnosis import InUse, in_words
from tacos_report.figures.canvas import NARROW_IN, draw, light_grid
from tacos_report.page import Page, Paragraph, Section, Table, in_both_widths


def page(found: InUse) -> Page:
    heads = (
        "exposure [ms]",
        "at rest",
        "in motion",
        "path [px]",
        "share of its blur",
        "95 %",
        "named in motion",
    )
    rows = tuple(
        (
            f"{blur.exposure_ms:g}",
            str(blur.frames_at_rest),
            str(blur.frames_moving),
            f"{blur.path_px:.1f}",
            "" if blur.share is None else f"{blur.share:.2f}",
            "" if blur.interval is None else f"{blur.interval[0]:.2f} to {blur.interval[1]:.2f}",
            "motion" if blur.present else "",
        )
        for blur in found.blurs
    )
    caption = "Detail lost beside a shorter exposure, over what blur along the path of each pixel would lose."

    def drawing(*, narrow: bool = False) -> str:
        return _response(found, narrow=narrow)

    sections = [
        Section("What was found", tuple(Paragraph(line) for line in in_words(found).splitlines())),
        Section("Response", (in_both_widths(drawing, "Light over code, found from the exposures alone."),)),
        Section("Motion", (Table(heads, rows, caption),)),
    ]
    lead = (
        "Frames of a moving camera at several exposures, set beside one another: no chart and no simulation."
    )
    return Page("Diagnosis of a recording", "A camera in use", lead, sections)


def _response(found: InUse, *, narrow: bool) -> str:
    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        response = found.response
        axes.plot(response.code_dn, response.light_dn)
        band = np.minimum(found.response_error, 1) * response.light_dn
        axes.fill_between(response.code_dn, response.light_dn - band, response.light_dn + band, alpha=0.3)
        axes.set(xlabel="code [DN]", ylabel="light [DN]")
        light_grid(axes, "y")

    size = (NARROW_IN, 3.0) if narrow else (7.0, 3.2)
    return draw(f"response{'-narrow' if narrow else ''}", size, "Light over code.", paint)
