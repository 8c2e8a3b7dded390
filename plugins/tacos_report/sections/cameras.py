"""The cameras side by side: what each reached on unseen scenes, and what each is."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import partial

from tacos_report import story
from tacos_report.comparison import CameraDifference, best_of, difference, score_names
from tacos_report.figures.score_terms import score_terms
from tacos_report.page import Block, Detailed, PagePicture, Paragraph, Table, in_both_widths
from tacos_report.palette import camera_variable
from tacos_report.pictures import picture
from tacos_report.quantities import joined, measured, percent, row_detail, shown, signed, unit_of, words
from tacos_report.study_data import CameraResult, StudyData

OF_PURCHASE = frozenset({"mount_fits", "image_circle_margin_mm", "f_number_min"})
"""Derived quantities that say whether parts go together: they stand where it says what to buy."""

_MAP_PX, _MAP_WIDEST_PX = 1000, 560
_OUTCOMES = {"better": "better", "worse": "worse", "undecided": "no clear difference"}

Row = tuple[str | Detailed, ...]


def title(study: StudyData) -> str:
    if not study.tested:
        return "The cameras"
    return "On scenes none of them was tuned on" if study.others else "On unseen scenes"


def blocks(study: StudyData) -> Iterator[Block]:
    if not study.cameras:
        return
    if not study.tested:
        yield Paragraph(story.untested(study))
    if best_of(study.cameras) is not None:
        names = list(story.score_weights(study))
        names = names or list(dict.fromkeys(score for camera in study.cameras for score in camera.terms))
        yield in_both_widths(
            partial(score_terms, study.cameras, names),
            "Each segment is a score times its weight. Error bars and ± are standard errors over the test "
            "episodes, where there is more than one.",
        )
    if study.tested:
        yield score_table(study)
        if study.others:
            yield Paragraph(
                "± is one standard error over the test scenes. Differences are taken scene by scene, since "
                "all cameras see the same scenes, and shown with their 95 % interval; one counts as clear "
                "where the interval leaves out zero.",
                quiet=True,
            )
    yield camera_table(study)
    if study.scene_map and (image := picture(study.scene_map, _MAP_PX, lossless=True)):
        caption = "One of the scenes from above, with the agent's path."
        yield PagePicture(image.uri, caption, widest_px=_MAP_WIDEST_PX)


def camera_table(study: StudyData) -> Table:
    return _table("Property", tuple(_properties(study)), "The cameras", study)


def score_table(study: StudyData) -> Table:
    """Scores and fitness on unseen scenes, with the change against the best other camera."""
    weights = story.score_weights(study)
    rows = tuple(
        _score_row(study, name, weights) for name in (*score_names(study.cameras, weights), "fitness")
    )
    caption = "Scores on unseen scenes"
    if study.others:
        caption += "; the last column compares the designed camera with the best other one"
    return _table("Score", rows, caption, study, *(["Change"] if study.others else []), total=True)


def _table(
    first: str, rows: tuple[Row, ...], caption: str, study: StudyData, *more: str, total: bool = False
) -> Table:
    colours = ("", *(camera_variable(i) for i in range(len(study.cameras))), *("" for _ in more))
    heads = (first, *(camera.title for camera in study.cameras), *more)
    return Table(heads, rows, caption, colours, row_heads=True, total=total)


def _properties(study: StudyData) -> Iterator[Row]:
    variables = _in_order(camera.camera for camera in study.cameras)
    for name in variables:
        yield (words(name), *(_variable_cell(camera, name, study) for camera in study.cameras))
    for name in _in_order(camera.derived for camera in study.cameras):
        if name in variables or name in OF_PURCHASE:
            continue
        unit = study.units.get(name) or unit_of(name)
        yield (
            words(name),
            *(
                shown(name, camera.derived[name], unit) if name in camera.derived else "not known"
                for camera in study.cameras
            ),
        )
    if any("vfov_deg" in camera.derived for camera in study.cameras):
        seen = (story.ground_words(study, camera) for camera in study.cameras)
        yield (f"{study.ground.capitalize()} seen ahead", *seen)
    if any(camera.free for camera in study.others):
        yield ("Optimised", *(_free_cell(camera) for camera in study.cameras))


def _score_row(study: StudyData, name: str, weights: Mapping[str, float]) -> Row:
    weight = weights.get(name)
    higher_first = story.higher_is_better(study, name)
    values = [camera.fitness if name == "fitness" else camera.scores.get(name) for camera in study.cameras]
    known = [value for value in values if value is not None]
    top = (max(known) if higher_first else min(known)) if len(known) > 1 and len(set(known)) > 1 else None
    cells = [
        Detailed(
            "none" if value is None else measured(value, camera.spread.get(name)),
            best=top is not None and value == top,
        )
        for camera, value in zip(study.cameras, values, strict=True)
    ]
    counted = (
        f"weight {weight:g}" if weight is not None else "" if name == "fitness" else "not in the fitness"
    )
    detail = "; ".join(filter(None, (study.score_meanings.get(name, ""), counted)))
    if study.others:
        cells.append(_change(study, name, higher_first))
    return (Detailed(words(name), detail), *cells)


def _change(study: StudyData, name: str, higher_first: bool) -> Detailed:
    other = best_of(study.others)
    if study.designed is None or other is None:
        return Detailed("")
    change = difference(study.designed, other, name, higher_is_better=higher_first)
    return Detailed(_change_text(change), _OUTCOMES.get(change.outcome, "") if change else "")


def _change_text(change: CameraDifference | None) -> str:
    if change is None:
        return ""
    if change.value == 0:
        return "the same"
    absolute = signed(change.value, change.error)
    return f"{percent(change.share)} ({absolute})" if change.share is not None else absolute


def _variable_cell(camera: CameraResult, name: str, study: StudyData) -> Detailed:
    if name not in camera.camera:
        return Detailed("none")
    value = camera.camera[name]
    detail = row_detail(value) if isinstance(value, dict) else ""
    return Detailed(shown(name, value, study.units.get(name) or unit_of(name)), detail)


def _free_cell(camera: CameraResult) -> Detailed:
    if not camera.free:
        return Detailed("nothing")
    tries = joined(str(camera.evaluations), "evaluations") if camera.evaluations else ""
    return Detailed(", ".join(words(name).lower() for name in camera.free), tries)


def _in_order(mappings: Iterable[Mapping[str, object]]) -> list[str]:
    """Every key of the mappings, in the order they first appear."""
    return list(dict.fromkeys(key for mapping in mappings for key in mapping))
