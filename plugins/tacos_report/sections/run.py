"""Cost and failures of the run, and how to repeat it."""

from __future__ import annotations

from collections.abc import Iterator

from tacos_report import story
from tacos_report.figures.time_spent import time_spent
from tacos_report.page import Block, Code, Drawing, Folded, Paragraph, SideBySide, Table
from tacos_report.plain_values import mapping
from tacos_report.quantities import words
from tacos_report.study_data import StudyData

_LOG_LINES = 200
_LABELS = {"gl_renderer": "OpenGL renderer", "cores": "Processor cores", "python": "Python"}


def costs(study: StudyData) -> Iterator[Block]:
    if size := story.size_words(study):
        yield Paragraph(f"{size}.")
    seconds_by_node = mapping(study.result.get("seconds_by_node"))
    spent = {name: float(seconds) for name, seconds in seconds_by_node.items() if seconds > 0}
    failures = story.failure_groups(study.tried)
    time = Drawing(time_spent(spent), "Time by part of the pipeline.") if spent else None
    table = Table(
        ("Candidates", "Reason, for example"),
        tuple((str(group.count), group.example) for group in failures),
        "Candidates without a fitness, by reason (numbers in a reason vary)",
    )
    yield SideBySide(
        (
            time or Paragraph("No times were recorded."),
            table if failures else Paragraph("No candidate failed."),
        )
    )


def repeat(study: StudyData) -> Iterator[Block]:
    result = study.result
    if command := result.get("command"):
        yield Code(str(command))
    seed = result.get("seed")
    rows = [("Seed", str(seed) if seed is not None else "not recorded")]
    rows.append(("tacos-framework", str(result.get("tacos") or "not recorded")))
    yield Table((), (*rows, *_environment(study)), row_heads=True)
    if study.recipe:
        yield Folded("The resolved recipe", (Code(study.recipe),))
    if log := "\n".join(study.log.splitlines()[-_LOG_LINES:]):
        yield Folded("End of the log", (Code(log),))


def _environment(study: StudyData) -> Iterator[tuple[str, str]]:
    environment = mapping(study.result.get("environment"))
    rows = {**environment, **mapping(environment.get("findings"))}
    packages = mapping(rows.pop("packages", None))
    rows.pop("findings", None)
    for name, value in rows.items():
        if isinstance(value, str | int | float):
            yield _LABELS.get(name, words(name)), str(value)
    if packages:
        yield "Packages", ", ".join(f"{name} {version}" for name, version in packages.items())
