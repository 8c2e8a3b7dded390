"""Each part of the ranking by itself: its cameras, scores and frames, and the command to design with it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from tacos_report.analysis import RankedPart
from tacos_report.page import Block, Code, ContactSheet, Detailed, Folded, PagePicture, Paragraph, Table
from tacos_report.pictures import picture
from tacos_report.plain_values import rows as plain_rows
from tacos_report.plain_values import text
from tacos_report.quantities import number, words
from tacos_report.story import optics_words, score_weights
from tacos_report.study_data import StudyData, parts_of

_MOST_TRIED = 3
_FRAME_PX = 240
"""Width of a frame [px]: twelve of them add a tenth of a megabyte to the page."""


def anchor(place: int) -> str:
    """Anchor of the part at a place of the ranking, from 1."""
    return f"part-{place}"


def blocks(study: StudyData) -> Iterator[Folded]:
    for place, part in enumerate(study.analysis.ranking, start=1):
        yield Folded(f"{place}. {part.part}", tuple(_of_part(study, part)), anchor(place))


def _of_part(study: StudyData, part: RankedPart) -> Iterator[Block]:
    has_part = _with_parts_of(part.camera)
    tested = [camera for camera in study.cameras if has_part(camera.camera)]
    tried = [each for each in study.scored if has_part(each.camera)]
    tried.sort(key=lambda each: -(each.fitness or 0.0))
    scores = list(score_weights(study))
    rows: list[tuple[str | Detailed, ...]] = []
    for camera in tested:
        if camera.fitness is not None:
            title = Detailed(camera.title, optics_words(camera.camera, study.units))
            rows.append((title, "test", *_numbers(camera.fitness, camera.scores, scores)))
    for each in tried[:_MOST_TRIED]:
        optics = optics_words(each.camera, study.units)
        rows.append((optics, "search", *_numbers(each.fitness, each.scores, scores)))
    if rows:
        heads = ("Camera", "Scenes", "Fitness", *(words(score) for score in scores))
        yield Table(heads, tuple(rows), f"Best of {len(tried)} candidates of the search" if tried else "")
    else:
        yield Paragraph("No camera with this part was rendered: its fitness is predicted by the surrogate.")
    frames = tuple(
        PagePicture(image.uri, f"{camera.title}, moment {moment}")
        for camera in tested
        for moment, sample in enumerate(camera.samples, start=1)
        if (image := picture(sample, _FRAME_PX))
    )
    if frames:
        yield ContactSheet(frames)
    elif rows:
        yield Paragraph("Frames are kept of the designed camera and of products.", quiet=True)
    if command := command_with(study, part):
        yield Code(command)


def command_with(study: StudyData, part: RankedPart) -> str:
    """The command of the study with this part alone to choose; empty where the study has no command."""
    command = text(study.result.get("command")).partition(" --out ")[0]
    names = parts_of(part.camera)
    chosen = [
        f"--set 'design.{variable}.only=[{names[variable]}]'"
        for row in plain_rows(study.result.get("design_space"))
        if row.get("kind") == "catalog" and names.get(variable := text(row.get("name")))
    ]
    return " ".join([command, *chosen, "--out runs/other_part"]) if command and chosen else ""


def _with_parts_of(camera: Mapping[str, Any]) -> Callable[[Mapping[str, Any]], bool]:
    """Tells the cameras that have the parts of this one; those equal to it where it has none."""
    parts = parts_of(camera)
    if not parts:
        return lambda other: dict(other) == dict(camera)
    return lambda other: parts.items() <= parts_of(other).items()


def _numbers(fitness: float | None, scores: Mapping[str, float], names: list[str]) -> Iterator[str]:
    for value in (fitness, *(scores.get(name) for name in names)):
        yield "" if value is None else number(value)
