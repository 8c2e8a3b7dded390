"""The tables of the report, cell by cell."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from tacos_report.comparison import CameraDifference, best_of, difference, score_names
from tacos_report.quantities import (
    joined,
    measured,
    percent,
    row_detail,
    shown,
    signed,
    unit_of,
    words,
)
from tacos_report.story import ground_words, higher_is_better, score_weights
from tacos_report.study_data import CameraResult, StudyData

OF_PURCHASE = frozenset({"mount_fits", "image_circle_margin_mm", "f_number_min"})
"""Derived quantities that say whether parts go together: told where it says what to buy."""


@dataclass(frozen=True)
class CameraCell:
    """Text, what is printed small below it, and whether it is the best of its row."""

    text: str
    detail: str = ""
    best: bool = False


@dataclass(frozen=True)
class CameraRow:
    """A label, its detail, and one cell per camera; ``change`` compares with the best other camera."""

    label: str
    cells: tuple[CameraCell, ...]
    detail: str = ""
    change: str = ""
    outcome: str = ""


def camera_table(study: StudyData) -> list[CameraRow]:
    """What each camera is: variables, derived quantities, the floor it sees, what was optimised for it."""
    rows = []
    variables = _in_order(camera.camera for camera in study.cameras)
    for name in variables:
        cells = tuple(_variable_cell(camera, name, study) for camera in study.cameras)
        rows.append(CameraRow(words(name), cells))
    for name in _in_order(camera.derived for camera in study.cameras):
        if name in variables or name in OF_PURCHASE:
            continue
        unit = study.units.get(name) or unit_of(name)
        cells = tuple(
            CameraCell(shown(name, camera.derived[name], unit) if name in camera.derived else "not known")
            for camera in study.cameras
        )
        rows.append(CameraRow(words(name), cells))
    if any("vfov_deg" in camera.derived for camera in study.cameras):
        floors = tuple(CameraCell(ground_words(study, camera)) for camera in study.cameras)
        rows.append(CameraRow(f"{study.ground.capitalize()} seen ahead", floors))
    if any(camera.free for camera in study.others):
        rows.append(CameraRow("Optimised", tuple(_free_cell(camera) for camera in study.cameras)))
    return rows


def score_table(study: StudyData) -> list[CameraRow]:
    """Scores and fitness on unseen scenes, with the change against the best other camera."""
    if not study.tested:
        return []
    weights = score_weights(study)
    names = [*score_names(study.cameras, weights), "fitness"]
    return [_score_row(study, name, weights) for name in names]


def _score_row(study: StudyData, name: str, weights: dict[str, float]) -> CameraRow:
    weight = weights.get(name)
    higher_first = higher_is_better(study, name)
    values = [camera.fitness if name == "fitness" else camera.scores.get(name) for camera in study.cameras]
    known = [value for value in values if value is not None]
    top = (max(known) if higher_first else min(known)) if len(known) > 1 and len(set(known)) > 1 else None
    cells = tuple(
        CameraCell(
            "none" if value is None else measured(value, camera.spread.get(name)),
            best=top is not None and value == top,
        )
        for camera, value in zip(study.cameras, values, strict=True)
    )
    other = best_of(study.others)
    change = None
    if study.designed is not None and other is not None:
        change = difference(study.designed, other, name, higher_is_better=higher_first)
    counted = (
        f"weight {weight:g}" if weight is not None else "" if name == "fitness" else "not in the fitness"
    )
    detail = "; ".join(filter(None, (study.score_meanings.get(name, ""), counted)))
    return CameraRow(words(name), cells, detail, _change_text(change), change.outcome if change else "")


def _change_text(change: CameraDifference | None) -> str:
    if change is None:
        return ""
    if change.value == 0:
        return "the same"
    absolute = signed(change.value, change.error)
    return f"{percent(change.share)} ({absolute})" if change.share is not None else absolute


def _variable_cell(camera: CameraResult, name: str, study: StudyData) -> CameraCell:
    if name not in camera.camera:
        return CameraCell("none")
    value = camera.camera[name]
    detail = row_detail(value) if isinstance(value, dict) else ""
    return CameraCell(shown(name, value, study.units.get(name) or unit_of(name)), detail)


def _free_cell(camera: CameraResult) -> CameraCell:
    if not camera.free:
        return CameraCell("nothing")
    tries = joined(str(camera.evaluations), "evaluations") if camera.evaluations else ""
    return CameraCell(", ".join(words(name).lower() for name in camera.free), tries)


def _in_order(mappings: Iterable[Mapping[str, object]]) -> list[str]:
    """Every key of the mappings, in the order they first appear."""
    return list(dict.fromkeys(key for mapping in mappings for key in mapping))
