"""The progress bar of ``tacos-run``."""

from __future__ import annotations

import logging
import time
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

from tacos_framework.cli import pace
from tacos_framework.cli.pace import Logged, Pace
from tacos_framework.cli.terminal import terminal_errors
from tacos_framework.errors import printable
from tacos_framework.simulation import Evaluation
from tacos_framework.study.progress import Progress, Silent

LONGEST_SILENCE_S = 20.0
"""While candidates are evaluated, a line comes at least so often [s]."""


@contextmanager
def progress_for(*, quiet: bool, verbose: bool = False) -> Iterator[Progress]:
    """Progress on standard error during a run, with the log.

    `quiet`: no progress, but warnings. Otherwise it is a live bar on a terminal, and lines elsewhere.
    `verbose`: all that is logged, not warnings alone; tracebacks in full.
    """
    console = Console(file=terminal_errors())
    lines = _LogLines(console, verbose=verbose)
    logging.root.addHandler(lines)
    try:
        with _shown_on(console, quiet=quiet) as shown:
            yield Logged(shown)
    finally:
        logging.root.removeHandler(lines)


@contextmanager
def _shown_on(console: Console, *, quiet: bool) -> Iterator[Progress]:
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


class _LogLines(logging.Handler):
    """Log lines on the console that draws the bars, so that they come above them and never into them.

    - `verbose`: all lines in full; otherwise of warnings and errors the first, as ``log.txt`` has the others.
    """

    def __init__(self, console: Console, *, verbose: bool):
        super().__init__(logging.INFO if verbose else logging.WARNING)
        self._console = console
        self._verbose = verbose
        self.addFilter(lambda record: record.name != pace.__name__)  # the bars say the same

    def emit(self, record: logging.LogRecord) -> None:
        text = self.format(record) if self._verbose else record.getMessage().partition("\n")[0]
        level = "" if record.levelno < logging.WARNING else f"{record.levelname.lower()}: "
        self._console.print(printable(f"{level}{text}"), markup=False, highlight=False, soft_wrap=True)


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
    """Lines for who reads along in a file: one per generation or step, and one now and then between."""

    def __init__(self, console: Console):
        self._console = console
        self._pace = Pace("", None)
        self._said_s = time.monotonic()

    def phase(self, title: str, candidates: int | None) -> None:
        self._pace = Pace(title, candidates)
        self._say(self._pace.title if candidates is None else f"{self._pace.title}: {candidates} to do")

    def evaluated(self, evaluation: Evaluation) -> None:
        self._pace.done += 1
        if time.monotonic() - self._said_s >= LONGEST_SILENCE_S:
            self._say(str(self._pace))

    def best(self, best: Evaluation | None) -> None:
        self._say(f"{self._pace}, best {_number(best.fitness if best else None)}")

    def step(self, note: str = "") -> None:
        self._pace.done += 1
        self._say(f"{self._pace}{note and f': {printable(note)}'}")

    def _say(self, line: str) -> None:
        self._console.print(line, highlight=False, soft_wrap=True)
        self._said_s = time.monotonic()


def _number(fitness: float | None) -> str:
    return "-" if fitness is None else f"{fitness:.3f}"
