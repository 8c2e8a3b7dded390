"""The report of a study as a page: the answer first, then what it rests on. It reads nothing, it arranges."""

from __future__ import annotations

from collections.abc import Iterator

from tacos_report import sections, story
from tacos_report.figures.footprints import footprints
from tacos_report.page import Block, Drawing, Hero, Legend, Page, PagePicture, Paragraph, Warnings
from tacos_report.palette import camera_variable
from tacos_report.pictures import MOST_ENLARGED, picture
from tacos_report.plain_values import text
from tacos_report.quantities import measured, row_detail, shown, words
from tacos_report.sections.cameras import OF_PURCHASE
from tacos_report.study_data import StudyData

_HERO_PX, _HERO_LEAST_PX = 1280, 480


def study_page(study: StudyData) -> Page:
    name = study.result.get("name")
    return Page(
        eyebrow=f"Camera study: {name}" if name else "Camera study",
        title=story.headline(study),
        lead=" ".join(filter(None, (story.verdict(study), story.per_score(study)))),
        sections=sections.of_study(study),
        header=tuple(_header(study)),
        tab_title=f"{name or 'Camera study'}: camera design report",
        version=str(study.result.get("tacos") or ""),
    )


def _header(study: StudyData) -> Iterator[Block]:
    """Header: the scene, the designed camera, the colours of the cameras, what to know before all else."""
    if conditions := text(study.result.get("conditions")):
        yield Paragraph(conditions)
    if (hero := _hero(study)) is not None:
        yield hero
    if len(study.cameras) > 1:
        yield Legend(tuple((camera.title, camera_variable(i)) for i, camera in enumerate(study.cameras)))
    yield Warnings("Before you rely on this", tuple(sections.cautions(study)))


def _hero(study: StudyData) -> Hero | None:
    """The designed camera's view, with the other frames drawn in where fields of view are known."""
    designed = study.designed
    if designed is None:
        return None
    facts = tuple(_facts(study))
    image = next((p for path in designed.samples if (p := picture(path, _HERO_PX))), None)
    if image is None:
        return Hero(facts)
    widest_px = max(_HERO_LEAST_PX, round(MOST_ENLARGED * image.width_px))
    if not {"hfov_deg", "vfov_deg"} <= designed.derived.keys():
        return Hero(facts, PagePicture(image.uri, "What the designed camera sees."), widest_px)
    others = ", with the frames of the other cameras at the same place drawn in (dashed); a frame that runs "
    others += "out of the picture sees more there"
    caption = f"What the designed camera sees (solid frame){others if study.others else ''}."
    return Hero(facts, Drawing(footprints(study.cameras, image.uri), caption), widest_px)


def _facts(study: StudyData) -> Iterator[tuple[str, str, str]]:
    """(label, value, detail) of the winner: its design variables, what follows from them, what it reached."""
    designed = study.designed
    if designed is None:
        return
    for name in story.in_order(designed.camera):
        value = designed.camera[name]
        detail = row_detail(value) if isinstance(value, dict) else ""
        yield words(name), shown(name, value, study.units.get(name)), detail
    for name, derived in designed.derived.items():
        if name not in designed.camera and name not in OF_PURCHASE:
            yield words(name), shown(name, derived, study.units.get(name)), ""
    if "vfov_deg" in designed.derived:
        seen = story.floor_words(designed, study.eye_height_m, study.ground)
        yield f"{study.ground.capitalize()} seen ahead", seen, ""
    if designed.fitness is not None:
        reached = measured(designed.fitness, designed.spread.get("fitness"))
        yield "Fitness on unseen scenes", reached, story.against_best(study)
