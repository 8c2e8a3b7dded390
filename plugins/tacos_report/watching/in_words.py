"""A running study as a sentence and as rows, the same in the terminal and on the page."""

from __future__ import annotations

from tacos_report.quantities import duration, number
from tacos_report.story import design_words
from tacos_report.watching.running_study import RunningStudy

HEADS = ("", "Camera", "Fitness", "In round")
"""The columns of the ranking."""


def state(study: RunningStudy, now_s: float) -> str:
    """State and progress of the run. `now_s`: the time, in seconds since the epoch."""
    done = f"{len(study.tried)} candidates scored, {number(study.images, 6)} images rendered"
    failed = f", {study.failed} failed" if study.failed else ""
    if study.stopped is not None:
        return f"Ended: {study.stopped}. {done}{failed}."
    heard = f"last heard of {duration(max(0.0, now_s - study.written_at_s))} ago. {done}{failed}."
    if study.is_running:
        return f"Running; {heard}"
    return f"Broken off, as no process works on it; {heard} Go on with it by --resume."


def ranking(study: RunningStudy) -> tuple[tuple[str, ...], ...]:
    """Rows for `HEADS`, the best first."""
    return tuple(
        (str(place), design_words(tried.camera), number(tried.fitness or 0.0, 4), str(tried.generation + 1))
        for place, tried in enumerate(study.ranking, 1)
    )
