"""Checkpoints of a study, from which it goes on with the help of what the journal has."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from tacos_framework.contracts import State
from tacos_framework.errors import UserError
from tacos_framework.store import Results
from tacos_framework.store.database import DATABASE, damage
from tacos_framework.store.run import CHECKPOINT
from tacos_framework.study.journal import Journal
from tacos_framework.study.run_files import GenerationLine, KeptCheckpoint, checked_type
from tacos_framework.study.search import Search

SHARE = 0.05
"""Most of a study's time that goes into checkpoints: in between, the journal has what was evaluated. They
grow with the study, so that one after each generation would take a time that grows with its square."""


class Checkpoints:
    """Writes checkpoints, and takes a study up from one.

    - `line_files`: the files that get a line for each generation.
    """

    def __init__(self, results: Results, journal: Journal, line_files: Sequence[str]) -> None:
        self._results, self._journal, self._line_files = results, journal, line_files
        self._weights: set[str] = set()
        self._not_before_s = 0.0

    def write(self, searches: Sequence[Search], rest: Callable[[], Mapping[str, Any]], *, now: bool) -> None:
        """Write a checkpoint, unless the last one is so fresh that the time is better spent otherwise.

        `rest`: gives what else there is to keep.
        """
        began = time.monotonic()
        if not now and began < self._not_before_s:
            return
        weights = self._written_weights(searches)
        found = {"searches": {search.name: search.state() for search in searches}, **rest()}
        with self._results.transaction() as database:
            lines = {name: database.count(name) for name in self._line_files}
            database.put(CHECKPOINT, 0, {**found, "weights": weights, "lines": lines})
            self._journal.clear()
        self._results.keep_weights(weights.values())
        took = time.monotonic() - began
        self._not_before_s = time.monotonic() + took * (1 / SHARE - 1)

    def _written_weights(self, searches: Sequence[Search]) -> dict[str, str]:
        """Files of what the tasks of each search know now, and knew at its end, for an extension."""
        files = {}
        for search in searches:
            for task, state in search.states.items():
                name = _file(search, task, search.rounds)
                if name not in self._weights:
                    self._results.write_state(name, state)
                    self._weights.add(name)
                files[f"{search.name}.{task}"] = name
                if (end := _file(search, task, search.generation)) in self._weights:
                    files[f"{search.name}.{task}.searched"] = end
        self._weights = set(files.values())
        return files

    def restore(self, checkpoint: Mapping[str, Any] | None, searches: Sequence[Search]) -> float:
        """Take up searches and files from a checkpoint, or from the start.

        Raises `UserError` when a file is damaged, or the checkpoint is of other searches.

        Returns: the time that had been spent as the journal has it [s].
        """
        left = self._journal.entries()
        seconds = max((kept.seconds for kept in left), default=0.0)
        if checkpoint is not None:
            self._check(checkpoint, searches)
            self._weights = set(checkpoint["weights"].values())
        names_of_journal = [name for kept in left for name in kept.weights.values()]
        self._results.keep_weights([*self._weights, *names_of_journal])
        self._cut_lines(checkpoint["lines"] if checkpoint else {})
        if checkpoint is not None:
            for search in searches:
                search.restore(checkpoint["searches"][search.name], self._states(checkpoint, search, ""))
        return seconds

    def _check(self, checkpoint: Mapping[str, Any], searches: Sequence[Search]) -> None:
        checked_type(KeptCheckpoint, self._path, CHECKPOINT, checkpoint)
        if set(checkpoint["searches"]) != {search.name for search in searches}:
            raise UserError(damage(self._path, "it is of other searches than the recipe's"))

    @property
    def _path(self) -> Path:
        return self._results.folder / DATABASE

    def states_at_end(self, checkpoint: Mapping[str, Any], search: Search) -> dict[str, State]:
        """States of the tasks after a search, before they were trained on the best camera."""
        return self._states(checkpoint, search, ".searched")

    def _states(self, checkpoint: Mapping[str, Any], search: Search, when: str) -> dict[str, State]:
        files = checkpoint["weights"]
        found = {}
        for task in search.states:
            place = f"{search.name}.{task}{when}"
            if place not in files:
                raise UserError(damage(self._path, f"it has no weights of {place}"))
            found[task] = self._results.read_state(files[place])
        return found

    def _cut_lines(self, counts: Mapping[str, int]) -> None:
        """Drop the generations since the checkpoint: they are taken from the journal once more."""
        for name in self._line_files:
            lines, count = self._results.read_lines(name), counts.get(name, 0)
            for number, line in enumerate(lines):
                checked_type(GenerationLine, self._path, f"{name} {number}", line)
            if len(lines) < count:
                raise UserError(damage(self._path, f"it has {len(lines)} of {count} lines of {name}"))
            self._results.write_lines(name, lines[:count])


def _file(search: Search, task: str, rounds: int) -> str:
    return f"{search.name}.{task}.{rounds if search.training else 0}"  # what is frozen is written once
