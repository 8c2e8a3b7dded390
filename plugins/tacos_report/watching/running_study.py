"""State of a study, from its folder, while it runs."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tacos_framework import Fault, UserError
from tacos_framework.files import read_bytes, read_text
from tacos_framework.store import is_in_use, read_run_json
from tacos_report.plain_values import text
from tacos_report.study_data import Generation, Tried, document_of, read_generations

MOST_SHOWN = 8
"""Cameras in the ranking."""


@dataclass(frozen=True)
class RunningStudy:
    name: str
    generations: tuple[Generation, ...]
    last_line: str  # the last line of its log, which says what it does
    written_at_s: float
    """When the study last wrote to its folder, in seconds since the epoch; pages are written by others
    too."""
    is_running: bool
    stopped: str | None  # why it ended; None while it runs, and where its process was killed
    report: Path | None

    @property
    def tried(self) -> tuple[Tried, ...]:
        return tuple(candidate for generation in self.generations for candidate in generation.tried)

    @property
    def images(self) -> int:
        return sum(generation.frames for generation in self.generations)

    @property
    def failed(self) -> int:
        return sum(candidate.fitness is None for candidate in self.tried)

    @property
    def ranking(self) -> tuple[Tried, ...]:
        """The best cameras so far, each once, as scored on the scenes of the search."""
        best: dict[str, Tried] = {}
        for candidate in self.tried:
            known = best.get(key := json.dumps(candidate.camera, sort_keys=True))
            if candidate.fitness is not None and (known is None or candidate.fitness > (known.fitness or 0)):
                best[key] = candidate
        return tuple(sorted(best.values(), key=lambda found: -(found.fitness or 0)))[:MOST_SHOWN]


def read_running(folder: Path) -> RunningStudy:
    """The study of a results folder as it stands now.

    Raises UserError where the folder is none of a study, or a file of it is damaged.
    """
    recipe = folder / "recipe.yaml"
    if not recipe.is_file():
        expected = "the folder that tacos-run was given with --out, or made in runs/"
        raise UserError(Fault(str(folder), "no run has begun here: there is no recipe.yaml", expected))
    result = _result(folder / "result.json")
    log = folder / "log.txt"
    lines = read_bytes(log, "lines_mb").decode("utf-8", "replace").splitlines() if log.is_file() else []
    report = folder / "report.html"
    return RunningStudy(
        name=text(document_of(read_text(recipe)).get("name")) or folder.name,
        generations=read_generations(folder / "generations.jsonl"),
        last_line=lines[-1] if lines else "",
        written_at_s=max(_written_at_s(folder)),
        is_running=is_in_use(folder),
        stopped=text(result.get("stopped")) or None,
        report=report if report.is_file() else None,
    )


def _result(path: Path) -> Mapping[str, Any]:
    return read_run_json(path) if path.exists() else {}


def _written_at_s(folder: Path) -> Iterator[float]:
    """Time of the last change of each file; one may go while we look, as those of sqlite do."""
    yield 0.0
    for path in folder.iterdir():
        with suppress(FileNotFoundError):
            if path.suffix != ".html":
                yield path.stat().st_mtime
