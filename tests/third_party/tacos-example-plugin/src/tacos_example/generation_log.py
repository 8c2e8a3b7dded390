"""Keeps a table of the generations beside the results of every study, for spreadsheets."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from tacos_framework import Evaluation, Recipe, hookimpl

NAME = "generations.csv"
COLUMNS = ("generation", "candidates", "failed", "best_of_generation", "best_so_far")


class GenerationLog:
    """Observes studies: it sees what happens, on copies, and cannot change it.

    Should it raise, as on a disk that is full, the study goes on without it.
    """

    def __init__(self) -> None:
        self._file: Path | None = None

    @hookimpl
    def tacos_study_started(self, recipe: Recipe, out: Path) -> None:
        """Begin the table, or go on with that of a run that is resumed."""
        self._file = out / NAME

    @hookimpl
    def tacos_generation_finished(
        self, generation: int, evaluated: Sequence[Evaluation], best: Evaluation | None
    ) -> None:
        """Add a line; those of generations that a resumed run makes once more are replaced."""
        if self._file is None:
            return
        fitnesses = [evaluation.fitness for evaluation in evaluated if evaluation.fitness is not None]
        line = {
            "generation": generation,
            "candidates": len(evaluated),
            "failed": sum(evaluation.failed is not None for evaluation in evaluated),
            "best_of_generation": max(fitnesses, default=""),
            "best_so_far": "" if best is None or best.fitness is None else best.fitness,
        }
        lines = [*self._lines(self._file, before=generation), line]
        with self._file.open("w", encoding="utf-8", newline="") as file:
            table = csv.DictWriter(file, COLUMNS)
            table.writeheader()
            table.writerows(lines)

    @hookimpl
    def tacos_study_finished(self) -> None:
        """Let go of the study."""
        self._file = None

    @staticmethod
    def _lines(file: Path, before: int) -> list[dict[str, str]]:
        if not file.exists():
            return []
        with file.open(encoding="utf-8", newline="") as table:
            return [line for line in csv.DictReader(table) if int(line["generation"]) < before]


observer = GenerationLog()
