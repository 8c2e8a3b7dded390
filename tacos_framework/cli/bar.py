"""The progress bar of ``tacos-run``."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.progress import Progress as Bars

from tacos_framework.cli.terminal import terminal_errors
from tacos_framework.errors import printable
from tacos_framework.simulation import Evaluation
from tacos_framework.study.progress import Progress, Silent


@contextmanager
def progress_for(*, quiet: bool) -> Iterator[Progress]:
    """A live bar on a terminal, a line per generation elsewhere, nothing when quiet."""
    console = Console(file=terminal_errors())
    if quiet:
        yield Silent()
    elif console.is_terminal:
        with Bars(
            TextColumn("{task.description:<28}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[note]}"),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            console=console,
        ) as bars:
            yield _Live(bars)
    else:
        yield _Lines(console)


class _Live:
    """One bar per phase."""

    def __init__(self, bars: Bars):
        self._bars = bars
        self._task: TaskID | None = None
        self._best: float | None = None

    def phase(self, title: str, candidates: int | None) -> None:
        self._finish()
        title = printable(title)
        self._best = None
        self._task = self._bars.add_task(title, total=candidates, note="")

    def _finish(self) -> None:
        """Elites that are taken from the cache leave a bar short of its estimate."""
        if self._task is not None:
            self._bars.update(self._task, total=self._bars.tasks[self._task].completed)

    def evaluated(self, evaluation: Evaluation) -> None:
        if self._task is not None:
            if evaluation.fitness is not None:
                self._best = max(evaluation.fitness, self._best or evaluation.fitness)
            self._bars.update(self._task, advance=1, note=f"best {_number(self._best)}")

    def best(self, best: Evaluation | None) -> None:
        if self._task is not None:
            self._bars.update(self._task, note=f"best {_number(best.fitness if best else None)}")

    def step(self, note: str = "") -> None:
        if self._task is not None:
            self._bars.update(self._task, advance=1, note=printable(note))


class _Lines:
    """A line per generation or step, for logs."""

    def __init__(self, console: Console):
        self._console = console
        self._title, self._done = "", 0

    def phase(self, title: str, candidates: int | None) -> None:
        title = printable(title)
        self._title, self._done = title, 0
        self._console.print(title if candidates is None else f"{title}: {candidates} to do", highlight=False)

    def evaluated(self, evaluation: Evaluation) -> None:
        self._done += 1

    def best(self, best: Evaluation | None) -> None:
        fitness = _number(best.fitness if best else None)
        self._console.print(f"{self._title}: {self._done} evaluated, best {fitness}", highlight=False)

    def step(self, note: str = "") -> None:
        self._done += 1
        self._console.print(
            f"{self._title}: {self._done} done{note and f', {printable(note)}'}", highlight=False
        )


def _number(fitness: float | None) -> str:
    return "-" if fitness is None else f"{fitness:.3f}"
