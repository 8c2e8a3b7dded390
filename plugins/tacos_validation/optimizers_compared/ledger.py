"""Evaluations shared by all runs of a comparison, kept on disk as they come."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from tacos_framework.cache import content_key
from tacos_framework.contracts import Executor
from tacos_framework.results import Results
from tacos_framework.simulation import EpisodeSpec, Evaluation, Evaluator, ScoreJob

FILE = "evaluations.jsonl"


@dataclass(frozen=True)
class Entry:
    """What an evaluation gave and cost.

    Parameters
    ----------
    fitness
        None when the candidate failed or breaks a constraint.
    images
        Images rendered for it.
    seconds
        Time it took [s].
    """

    fitness: float | None
    images: int
    seconds: float


class Ledger:
    """Evaluates each candidate once, whoever asks for it, and remembers what that cost.

    As the episodes are the same for all runs, an evaluation is a function of the candidate alone. Runs that
    ask for a candidate another run has had still pay its images and seconds: the ledger saves the computer
    work, not the optimizers.

    Parameters
    ----------
    evaluate
        The simulation.
    episodes
        What candidates are scored on.
    executor
        Where that is done.
    results
        The results folder; entries that stand there already are taken over.
    """

    def __init__(
        self, evaluate: Evaluator, episodes: Sequence[EpisodeSpec], executor: Executor, results: Results
    ) -> None:
        self._evaluate = evaluate
        self._episodes = tuple(episodes)
        self._executor = executor
        self._results = results
        self._name = content_key([asdict(spec) for spec in episodes])
        self._entries: dict[str, Entry] = {}
        kept = results.read_lines(FILE)
        results.write_lines(FILE, kept)  # a last line that was cut short goes
        for line in kept:
            if line["episodes"] == self._name:
                entry = Entry(line["fitness"], line["images"], line["seconds"])
                self._entries[line["key"]] = entry

    def __len__(self) -> int:
        return len(self._entries)

    @property
    def entries(self) -> Iterable[Entry]:
        """Everything evaluated."""
        return self._entries.values()

    def warm_up(self, values: Mapping[str, Any], workers: int) -> int:
        """Evaluate a candidate in every worker and note nothing, so that no entry pays for building worlds.

        Returns the images it took; 0 when it could not be scored.
        """
        jobs = [ScoreJob(values, self._episodes)] * workers
        return max(evaluation.images for evaluation in self._executor.map(self._evaluate, jobs))

    def look_up(self, wanted: Iterable[Mapping[str, Any]]) -> None:
        """Evaluate those of the candidates that are not known yet."""
        new = {key: values for values in wanted if (key := content_key(values)) not in self._entries}
        jobs = [ScoreJob(values, self._episodes) for values in new.values()]
        for key, evaluation in zip(new, self._executor.map(self._evaluate, jobs), strict=True):
            entry = _entry(evaluation)
            self._entries[key] = entry
            self._results.append_line(FILE, {"episodes": self._name, "key": key, **asdict(entry)})

    def __getitem__(self, values: Mapping[str, Any]) -> Entry:
        """The entry of a candidate that was looked up."""
        return self._entries[content_key(values)]


def _entry(evaluation: Evaluation) -> Entry:
    return Entry(evaluation.fitness, evaluation.images, sum(evaluation.seconds.values()))
