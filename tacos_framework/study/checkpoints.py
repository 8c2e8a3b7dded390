"""Checkpoints of a study, from which it goes on with the help of what the journal has."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from tacos_framework.contracts import State
from tacos_framework.errors import UserError
from tacos_framework.results import Results
from tacos_framework.results.checksums import Damaged
from tacos_framework.results.reading import damage
from tacos_framework.results.results import CHECKPOINT
from tacos_framework.study.journal import JOURNAL, Journal
from tacos_framework.study.run_files import GenerationLine, JournalLine, KeptCheckpoint, check_type
from tacos_framework.study.search import Search

SHARE = 0.05
"""Most of a study's time that goes into checkpoints: in between, the journal has what was evaluated. They
grow with the study, so that one after each generation would take a time that grows with its square."""


class Checkpoints:
    """Writes checkpoints, and takes a study up from one.

    Parameters
    ----------
    results
        The folder of the run.
    journal
        What was evaluated since the last checkpoint.
    line_files
        The files that get a line for each generation.
    """

    def __init__(self, results: Results, journal: Journal, line_files: Sequence[str]) -> None:
        self._results, self._journal, self._line_files = results, journal, line_files
        self._weights: dict[str, str] = {}
        self._not_before_s = 0.0

    def write(self, searches: Sequence[Search], rest: Callable[[], Mapping[str, Any]], *, now: bool) -> None:
        """Write a checkpoint, unless the last one is so fresh that the time is better spent otherwise.

        Parameters
        ----------
        searches
            Those of the study.
        rest
            Gives what else there is to keep.
        """
        began = time.monotonic()
        if not now and began < self._not_before_s:
            return
        weights = self._written_weights(searches)
        self._results.write_checkpoint(
            {
                "searches": {search.name: search.state() for search in searches},
                "weights": weights,
                "lines": {name: self._results.end_of(name) for name in self._line_files},
                "samples": self._results.samples,
                **rest(),
            }
        )
        self._journal.clear()
        self._results.keep_weights(name for name, _ in weights.values())
        took = time.monotonic() - began
        self._not_before_s = time.monotonic() + took * (1 / SHARE - 1)

    def _written_weights(self, searches: Sequence[Search]) -> dict[str, tuple[str, str]]:
        """Files of what the tasks of each search know now, and knew at its end, for an extension."""
        files = {}
        for search in searches:
            for task, state in search.states.items():
                name = _file(search, task, search.rounds)
                if name not in self._weights:
                    self._weights[name] = self._results.write_state(name, state)
                files[f"{search.name}.{task}"] = name
                if (end := _file(search, task, search.generation)) in self._weights:
                    files[f"{search.name}.{task}.searched"] = end
        self._weights = {name: self._weights[name] for name in files.values()}
        return {place: (name, self._weights[name]) for place, name in files.items()}

    def restore(self, checkpoint: Mapping[str, Any] | None, searches: Sequence[Search]) -> float:
        """Take up searches and files from a checkpoint, or from the start.

        Raises
        ------
        UserError
            When a file is damaged, or the checkpoint is of other searches.

        Returns
        -------
        The time that had been spent as the journal has it [s].
        """
        folder = self._results.folder
        check_type(folder / JOURNAL, JournalLine, self._results.lines_of(JOURNAL).values)
        seconds = self._journal.read()
        if checkpoint is None:
            for name in self._line_files:
                self._results.write_lines(name, [])
            self._results.keep_weights(self._journal.weights)
            return seconds
        path = folder / CHECKPOINT
        check_type(path, KeptCheckpoint, [checkpoint])
        if set(checkpoint["searches"]) != {search.name for search in searches}:
            raise UserError(damage(path, "it is of other searches than the recipe's"))
        self._weights = dict(checkpoint["weights"].values())
        self._results.keep_weights([*self._weights, *self._journal.weights])
        for search in searches:
            search.restore(checkpoint["searches"][search.name], self._states(checkpoint, search, ""))
        self._cut_lines(checkpoint["lines"])
        return seconds

    def states_at_end(self, checkpoint: Mapping[str, Any], search: Search) -> dict[str, State]:
        """What the tasks of a search knew when it had ended, before they were trained on the best camera."""
        return self._states(checkpoint, search, ".searched")

    def _states(self, checkpoint: Mapping[str, Any], search: Search, when: str) -> dict[str, State]:
        files = checkpoint["weights"]
        found = {}
        for task in search.states:
            place = f"{search.name}.{task}{when}"
            if place not in files:
                raise UserError(damage(self._results.folder / CHECKPOINT, f"it has no weights of {place}"))
            found[task] = self._results.read_state(*files[place])
        return found

    def _cut_lines(self, ends: Mapping[str, Mapping[str, Any]]) -> None:
        """Drop the generations since the checkpoint: they are taken from the journal once more."""
        for name in self._line_files:
            lines = self._results.lines_of(name)
            path = self._results.folder / name
            check_type(path, GenerationLine, lines.values)
            try:
                lines.check_reaches(ends.get(name, {"lines": 0}))
            except Damaged as error:
                raise UserError(damage(path, str(error))) from error
            self._results.write_lines(name, lines.values[: ends.get(name, {"lines": 0})["lines"]])


def _file(search: Search, task: str, rounds: int) -> str:
    return f"{search.name}.{task}.{rounds if search.training else 0}"  # what is frozen is written once
