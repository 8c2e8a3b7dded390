"""Shopping list: parts, lens, mounting, and what no source states of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from tacos_report.page import Block, Paragraph, SideBySide, Table, Warnings
from tacos_report.plain_values import finite, showable
from tacos_report.prices import price_words
from tacos_report.quantities import number, quantity, shown, unit_of, words
from tacos_report.study_data import CameraResult, StudyData

_PROSE = ("name", "title", "source", "sources", "notes", "doubts", "grade", "provenance")
"""Columns of a part that tell about its data sheet, not about the part."""


def blocks(study: StudyData) -> Iterator[Block]:
    designed, parts = study.designed, _parts(study)
    if designed is None or not parts:
        return
    if better := _better_product(study):
        yield Paragraph(
            f"The {better}, which was better in the test. If it is not available, the designed camera:"
        )
    tables = [_part_table(variable, part) for variable, part in parts.items()]
    if "focal_length_mm" in designed.camera and "lens" not in parts:
        tables.append(Table(("Lens", "to be found"), tuple(_lens_wanted(designed, study))))
    yield SideBySide(tuple(tables))
    fit = _fit(designed) if "lens" in parts else ()
    price = price_words(designed.camera)
    cost = (("Price of one of each", price),) if price else ()
    if together := (*cost, *fit, *_mounting(designed, study)):
        yield Table(("Together", ""), together)
    yield Warnings("Before you order", doubts(study))


def doubts(study: StudyData) -> tuple[str, ...]:
    """Notes of the study on the parts to buy; none where there is nothing to buy."""
    parts = _parts(study)
    return tuple(note for note in study.notes if any(str(each["name"]) in note for each in parts.values()))


def _parts(study: StudyData) -> dict[str, Mapping[str, Any]]:
    """The parts of the designed camera by variable; none where no camera may be named."""
    if study.designed is None or study.analysis.degenerate:
        return {}
    return {name: value for name, value in study.designed.camera.items() if isinstance(value, Mapping)}


def _better_product(study: StudyData) -> str | None:
    decision = study.analysis.decision
    if decision is None or decision.comparison.verdict != "worse":
        return None
    return study.title_of(decision.comparison.against)


def _part_table(variable: str, part: Mapping[str, Any]) -> Table:
    rows = list(_properties(part))
    if unknown := [words(str(name)).lower() for name, value in part.items() if value is None]:
        rows.append(("Not published", ", ".join(unknown)))
    return Table((words(variable), shown(variable, dict(part))), tuple(rows))


def _properties(part: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Known values of a part, column by column; pixels and millimetres of its two sides in one row each."""
    pairs = {"width_px": ("height_px", "Pixels", "px"), "width_mm": ("height_mm", "Active area", "mm")}
    done = {other for other, _, _ in pairs.values()}
    for name, value in part.items():
        own, other = finite(value), finite(part.get(pairs[name][0])) if name in pairs else None
        if own is not None and other is not None:
            _, title, unit = pairs[name]
            yield title, f"{number(own, 4)} × {quantity(other, unit, 4)}"
        elif name not in done and name not in _PROSE and showable(value):
            yield words(name), shown(name, value)


def _lens_wanted(camera: CameraResult, study: StudyData) -> Iterator[tuple[str, str]]:
    yield "Focal length", shown("focal_length_mm", camera.camera["focal_length_mm"])
    width_mm, height_mm = (camera.derived.get(f"sensor_{side}_mm") for side in ("width", "height"))
    if width_mm is not None and height_mm is not None:
        diagonal_mm = math.hypot(width_mm, height_mm)
        yield "Image circle", f"at least {quantity(diagonal_mm, 'mm')}, the diagonal of the sensor"
    if "hfov_deg" in camera.derived:
        field = quantity(camera.derived["hfov_deg"], "deg")
        yield "Horizontal field of view", f"{field}, simulated without distortion"
    if study.f_number is not None:
        yield "F-number", f"{number(study.f_number)} or less, as simulated"


def _fit(camera: CameraResult) -> tuple[tuple[str, str], ...]:
    margin_mm = camera.derived.get("image_circle_margin_mm")
    circle = "unknown: the image circle is not published"
    if margin_mm is not None:
        covers = "covers the sensor" if margin_mm >= 0 else "leaves the corners of the sensor dark"
        circle = f"{covers}: {quantity(abs(margin_mm), 'mm', 2)} {'to spare' if margin_mm >= 0 else 'short'}"
    fits = camera.derived.get("mount_fits")
    mount = "unknown: a mount is not published" if fits is None else "fits" if fits else "does not fit"
    return ("Image circle of the lens", circle), ("Mount of the lens", mount)


def _mounting(camera: CameraResult, study: StudyData) -> Iterator[tuple[str, str]]:
    for name, value in camera.camera.items():
        if name != "focal_length_mm" and showable(value):
            yield words(name), shown(name, value, study.units.get(name) or unit_of(name))
