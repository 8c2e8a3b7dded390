"""Puts the report of a diagnosis together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from tacos_framework.store import DESIGNED
from tacos_gap.answer.findings import Diagnosis
from tacos_gap.captures import CaptureFolder, RealCapture
from tacos_gap.inference.problem import placed
from tacos_gap.report import bars, task_words, words
from tacos_gap.report.drawings import Artist
from tacos_gap.report.frames import ComparedFrames, compare, to_show
from tacos_gap.report.gap_and_causes import causes, where
from tacos_gap.report.numbers import capture_gaps, numbers_of
from tacos_gap.report.photographed import not_told, nuisance_rows, photographed
from tacos_report.page import (
    Block,
    Code,
    Folded,
    Heading,
    Page,
    PagePicture,
    Paragraph,
    Section,
    SideBySide,
    Table,
    image_uri,
    in_both_widths,
)
from tacos_report.quantities import duration, number
from tacos_report.story import design_words

SIMULATIONS = ("real", "simulated", "simulated with the causes")
MOST_SCORES = 3
"""Scores of tasks that are drawn."""


@dataclass(frozen=True)
class Circumstances:
    """Circumstances of a run, for who wants to repeat it."""

    seed: int
    command: str
    patch: str
    seconds: float
    without: tuple[str, ...] = ()
    decision: Mapping[str, Any] = field(default_factory=dict)
    """What becomes of a study; empty where none was asked for."""
    considered: Mapping[str, type[Any]] = field(default_factory=dict)


def page(diagnosis: Diagnosis, folder: CaptureFolder, run: Circumstances) -> Page:
    best = diagnosis.attribution.best
    numbers = numbers_of(diagnosis.problem, diagnosis.problem.null, best.held_out)
    after = "with the causes" if best.hypothesis else None
    artist = Artist(diagnosis.problem, folder.captures, best.hypothesis, run.seed, after=after)
    gaps = capture_gaps(diagnosis)
    shown = [compare(c, placed(best.hypothesis, c.id), run.seed) for c in to_show(folder.captures, gaps)]
    explained = diagnosis.verdict == "explained"
    sections = [
        Section("Captures", tuple(photographed(folder.captures))),
        *([Section("Real and simulated", tuple(_frames(shown, explained=explained)))] if shown else []),
        Section("Where the gap lies", tuple(where(diagnosis, numbers, artist))),
        *([Section("Causes", tuple(causes(diagnosis, artist)))] if diagnosis.causes else []),
        Section("Closure", tuple(_closure(diagnosis))),
        *([Section("Consequences for tasks", tuple(_task(diagnosis)))] if diagnosis.task else []),
        *([Section("Does the decision change", tuple(_decision(run.decision)))] if run.decision else []),
        Section("Limits of these captures", tuple(_limits(diagnosis, folder.captures, run))),
        *([Section("Use the better simulator", tuple(_patch(diagnosis, run)))] if diagnosis.causes else []),
        Section("To repeat it", tuple(_repeat(diagnosis, folder.captures, gaps, run))),
    ]
    return Page(
        "Diagnosis of the gap between captures and their simulation",
        words.headline(diagnosis),
        words.lead(diagnosis, len(folder.captures)),
        [section for section in sections if section.blocks],
    )


def _frames(shown: Sequence[ComparedFrames], *, explained: bool) -> Iterator[Block]:
    for pair in shown:
        yield Heading(f"{pair.capture}, {pair.kind}")
        yield SideBySide(_pictures(pair.whole, SIMULATIONS))
        yield SideBySide(
            _pictures(pair.crops, tuple(f"{t}, the part that differs most" for t in SIMULATIONS))
        )
        differences = _pictures(
            pair.differences, ("real less simulated", "real less simulated with the causes")
        )
        yield SideBySide(differences)
        note = " Levels are stretched: the frames are nearly even." if pair.stretched else ""
        yield Paragraph(
            "Differences are means over the frames; blue is darker than simulated, vermilion brighter, in "
            f"full colour at {number(pair.reach_dn, 2)} DN, on one scale.{note} "
            f"{words.picture_remainder(pair.rms_dn, pair.noise_dn, explained=explained)}"
        )


def _pictures(images: Sequence[Any], titles: Sequence[str]) -> tuple[PagePicture, ...]:
    return tuple(
        PagePicture(image_uri(image), title, enlarged=True)
        for image, title in zip(images, titles, strict=False)
    )


def _closure(diagnosis: Diagnosis) -> Iterator[Block]:
    if diagnosis.causes:
        yield in_both_widths(
            partial(bars.closures, diagnosis),
            f"The line on the first bar is its 90 % interval.{words.control_sentence(diagnosis)}",
        )
    for sentence in words.not_held_out(diagnosis):
        yield Paragraph(sentence)
    yield Paragraph(words.remainder(diagnosis))
    if nuisances := nuisance_rows(diagnosis.nuisances):
        heads = ("capture", "expected values were off by")
        yield Folded(
            "Allowed for: light, pose and focus, which are never known exactly", (Table(heads, nuisances),)
        )


def _task(diagnosis: Diagnosis) -> Iterator[Block]:
    first = dict(list(diagnosis.task.items())[:MOST_SCORES])
    yield in_both_widths(
        partial(bars.task_scores, first),
        "Tasks on the captures that show something: on the real frames, on simulated ones, and with the "
        "causes; lines are 90 % intervals over the noise. A simulator whose frames score like the real ones "
        "can be trusted with the task.",
    )
    for name, found in first.items():
        yield Paragraph(task_words.sentence(name, found))
    heads = ("score", "real", "simulated", "with the causes")
    yield Folded("All scores", (Table(heads, task_words.rows(diagnosis.task)),))


def _decision(decision: Mapping[str, Any]) -> Iterator[Block]:
    yield in_both_widths(
        partial(bars.decision, decision["cameras"]),
        f"Cameras of {decision['study']}, on the same unseen scenes in either simulation. What a camera "
        f"leaves free is optimised in each, in few evaluations.{_frozen(decision)}",
    )
    yield Paragraph(str(decision["sentence"]))
    designed = decision[DESIGNED]
    if designed:
        yield Paragraph(
            f"Designed as simulated before: {design_words(designed['without'])}. With the causes: "
            f"{design_words(designed['with'])}."
        )


def _frozen(decision: Mapping[str, Any]) -> str:
    frozen = list(decision.get("frozen", ()))
    return f" {words.listed(frozen)}: weights as they were trained before." if frozen else ""


def _limits(diagnosis: Diagnosis, captures: Sequence[RealCapture], run: Circumstances) -> Iterator[Block]:
    if diagnosis.next_capture is not None:
        capture = diagnosis.next_capture
        yield Paragraph(f"Capture next: {capture.kind}. {capture.why[:1].upper()}{capture.why[1:]}.")
    said = words.cannot_tell(diagnosis)
    if not said and diagnosis.next_capture is None:
        yield Paragraph("All findings are proven.")
    for sentence in said:
        yield Paragraph(sentence)
    yield from not_told(captures, run.considered, diagnosis)


def _patch(diagnosis: Diagnosis, run: Circumstances) -> Iterator[Block]:
    yield Code(run.patch)
    yield Paragraph(
        "patched.yaml, beside this page, has these effects. If their folder is called out, design the next "
        "camera with them:"
    )
    yield Code("tacos-run headset_quick --with out/patched.yaml")
    if own := words.of_this_camera(diagnosis.causes):
        yield Paragraph(own)


def _repeat(
    diagnosis: Diagnosis,
    captures: Sequence[RealCapture],
    gaps: Mapping[str, tuple[float, float]],
    run: Circumstances,
) -> Iterator[Block]:
    yield Code(run.command)
    explained = diagnosis.unknown.by_capture
    rows = []
    for capture in captures:
        before, after = gaps.get(capture.id, (None, None))
        height, width = capture.valid.shape
        rows.append(
            (
                capture.id,
                capture.kind,
                str(capture.frames),
                f"{width} × {height}",
                "not compared" if before is None else number(before, 2),
                "" if after is None else number(after, 2),
                *([f"{1 - explained[capture.id]:.2f}" if capture.id in explained else ""] * bool(explained)),
            )
        )
    heads = ("capture", "kind", "frames", "size [px]", "gap before", "after")
    yield Table((*heads, *(["fully explained"] if explained else [])), tuple(rows))
    facts = [f"Seed {run.seed}", f"{len(diagnosis.problem.labels)} numbers compared"]
    facts.append(f"{diagnosis.problem.simulations} simulations of all captures")
    facts.append(duration(run.seconds))
    if run.without:
        facts.append(f"not considered: {', '.join(run.without)}")
    yield Paragraph("; ".join(facts) + ". diagnosis.json has all numbers.")
