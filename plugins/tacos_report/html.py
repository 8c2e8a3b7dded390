"""Puts the report together: reads nothing, fetches nothing, only arranges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from markupsafe import Markup

from tacos_report import sections, story
from tacos_report.comparison import best_of
from tacos_report.figures.catalog_choices import catalog_choices
from tacos_report.figures.explored import Panel, explored
from tacos_report.figures.footprints import footprints
from tacos_report.figures.score_terms import score_terms
from tacos_report.figures.search_curve import search_curve
from tacos_report.figures.side_view import side_view
from tacos_report.figures.time_spent import time_spent
from tacos_report.figures.top_view import top_view
from tacos_report.page import Drawing, in_both_widths, page_templates
from tacos_report.palette import camera_variable, stylesheet
from tacos_report.pictures import MOST_ENLARGED, picture, row_width_px, side_by_side
from tacos_report.plain_values import finite, mapping
from tacos_report.quantities import measured, row_detail, shown, unit_of, words
from tacos_report.study_data import StudyData, Tried, parts_of
from tacos_report.tables import OF_PURCHASE, camera_table, score_table

_HERO_PX, _HERO_LEAST_PX, _FRAME_PX, _MAP_PX = 1280, 480, 640, 1000
_MOMENTS_SHOWN = 3
_LOG_LINES = 200
_OPTIONAL = ("name", "stopped", "command", "seed", "tacos")


def render(study: StudyData) -> str:
    """The whole page."""
    return (
        page_templates()
        .get_template("study.html.j2")
        .render(
            study=study,
            result={**dict.fromkeys(_OPTIONAL), **study.result},
            palette=Markup(stylesheet()),
            story=story,
            hero=_hero(study),
            facts=_facts(study),
            cautions=sections.cautions(study),
            answers=sections.answers(study),
            by_scenario=sections.by_scenario(study),
            moments=_moments(study),
            views=_views(study),
            legend=[(camera.title, camera_variable(i)) for i, camera in enumerate(study.cameras)],
            scores=_scores(study),
            camera_rows=camera_table(study),
            score_rows=score_table(study),
            scene_map=picture(study.scene_map, _MAP_PX, lossless=True) if study.scene_map else None,
            search=in_both_widths(partial(search_curve, study.generations, study.shows_design))
            if study.scored
            else None,
            space=_space(study),
            time=_time(study.result.get("seconds_by_node")),
            failures=story.failure_groups(study.tried),
            environment=_environment(study.result.get("environment")),
            log="\n".join(study.log.splitlines()[-_LOG_LINES:]),
        )
    )


def _hero(study: StudyData) -> dict[str, Any] | None:
    """The designed camera's picture, with the other frames drawn in where fields of view are known."""
    designed = study.designed
    image = next(
        (p for path in (designed.samples if designed else ()) if (p := picture(path, _HERO_PX))), None
    )
    if designed is None or image is None:
        return None
    known = {"hfov_deg", "vfov_deg"} <= designed.derived.keys()
    drawing = footprints(study.cameras, image.uri) if known else None
    widest_px = max(_HERO_LEAST_PX, round(MOST_ENLARGED * image.width_px))
    return {"image": image, "widest_px": widest_px, "drawing": Markup(drawing) if drawing else None}


def _facts(study: StudyData) -> list[tuple[str, str, str]]:
    """(label, value, detail) of the winner: its design variables, what follows from them, what it reached."""
    designed = study.designed
    if designed is None:
        return []
    rows = []
    for name in story.in_order(designed.camera):
        value = designed.camera[name]
        detail = row_detail(value) if isinstance(value, dict) else ""
        rows.append((words(name), shown(name, value, study.units.get(name)), detail))
    for name, value in designed.derived.items():
        if name not in designed.camera and name not in OF_PURCHASE:
            rows.append((words(name), shown(name, value, study.units.get(name)), ""))
    if "vfov_deg" in designed.derived:
        rows.append(
            (
                f"{study.ground.capitalize()} seen ahead",
                story.floor_words(designed, study.eye_height_m, study.ground),
                "",
            )
        )
    if designed.fitness is not None:
        reached = measured(designed.fitness, designed.spread.get("fitness"))
        rows.append(("Fitness on unseen scenes", reached, story.against_best(study)))
    return rows


def _moments(study: StudyData) -> list[dict[str, Any]]:
    """Rows of frames of the same moment, one frame per camera, to one angular scale, and how wide at most."""
    cameras = [(index, camera) for index, camera in enumerate(study.cameras) if camera.samples]
    if not cameras:
        return []
    placed = side_by_side([camera for _, camera in cameras])
    count = min(_MOMENTS_SHOWN, *(len(camera.samples) for _, camera in cameras))
    moments = []
    for moment in range(count):
        frames: list[dict[str, Any]] = [
            {"camera": camera, "colour": camera_variable(index), "image": image, "place": place}
            for (index, camera), place in zip(cameras, placed, strict=True)
            if (image := picture(camera.samples[moment], _FRAME_PX))
        ]
        if frames:
            images, places = [f["image"] for f in frames], [f["place"] for f in frames]
            moments.append({"frames": frames, "widest_px": row_width_px(images, places)})
    return moments


def _views(study: StudyData) -> dict[str, Markup]:
    views = {}
    if any("vfov_deg" in camera.derived for camera in study.cameras):
        views["side"] = Markup(side_view(study.cameras, study.eye_height_m, study.carrier, study.ground))
    if any("hfov_deg" in camera.derived for camera in study.cameras):
        views["top"] = Markup(top_view(study.cameras))
    return views


def _scores(study: StudyData) -> Drawing | None:
    if best_of(study.cameras) is None:
        return None
    names = list(story.score_weights(study))
    names = names or list(dict.fromkeys(score for camera in study.cameras for score in camera.terms))
    return in_both_widths(partial(score_terms, study.cameras, names))


def _space(study: StudyData) -> dict[str, Any]:
    """The design space as a table, scatter plots of what is a number, lists of what comes from a catalog."""
    scored = study.scored
    rows = [(words(row["name"]), row, story.space_words(row)) for row in study.design_space]
    if not scored:
        return {"rows": rows, "scatter": None, "catalogs": []}
    designed = parts_of(study.designed.camera) if study.designed else {}
    panels = _panels(study, scored)
    return {
        "rows": rows,
        "scatter": in_both_widths(partial(explored, panels, scored)) if panels else None,
        "catalogs": [
            (words(name), in_both_widths(partial(catalog_choices, name, scored, designed.get(name))))
            for name in parts_of(scored[0].camera)
        ],
    }


def _panels(study: StudyData, scored: Sequence[Tried]) -> list[Panel]:
    """One panel per numeric variable, within its bounds, then one per derived quantity."""
    bounds = {row["name"]: (row.get("lower"), row.get("upper")) for row in study.design_space}
    numeric = [name for name, value in scored[0].camera.items() if isinstance(value, int | float)]
    designed = {**study.designed.derived, **study.designed.camera} if study.designed else {}
    panels = []
    for name in dict.fromkeys([*numeric, *scored[0].derived]):
        values = [tried.camera.get(name, tried.derived.get(name)) for tried in scored]
        unit = study.units.get(name) or unit_of(name)
        panels.append(
            Panel(name, unit, tuple(values), finite(designed.get(name)), *bounds.get(name, (None, None)))
        )
    return panels


def _time(seconds_by_node: Mapping[str, float] | None) -> Markup | None:
    spent = {name: float(seconds) for name, seconds in (seconds_by_node or {}).items() if seconds > 0}
    return Markup(time_spent(spent)) if spent else None


def _environment(environment: Mapping[str, Any] | None) -> dict[str, Any]:
    """What the study ran on, and the packages apart: they are many."""
    rows = {**(environment or {}), **mapping((environment or {}).get("findings"))}
    packages = mapping(rows.pop("packages", None))
    rows.pop("findings", None)
    labels = {"gl_renderer": "OpenGL renderer", "cores": "Processor cores", "python": "Python"}
    return {
        "rows": [
            (labels.get(name, words(name)), value)
            for name, value in rows.items()
            if isinstance(value, str | int | float)
        ],
        "packages": packages,
    }
