"""Scores of cameras on episodes: each pair is simulated once, whoever asks, and kept on disk as it comes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from tacos_framework.cache import content_key
from tacos_framework.contracts import Executor, Scores, State
from tacos_framework.plan import Plan
from tacos_framework.results import Results
from tacos_framework.simulation import EpisodeSpec, Evaluation, Evaluator, ScoreJob, merged_evaluation

FILE = "scores.jsonl"

Wanted = tuple[Mapping[str, Any], EpisodeSpec]
"""Plain values of a camera, and an episode to score it on."""


@dataclass(frozen=True)
class TableRow:
    """What one episode told of one camera.

    Parameters
    ----------
    scores
        The scores in each scenario by its name, which is empty where there is only one.
    failed
        Why there are none, in a sentence.
    images
        Images rendered.
    seconds
        Time it took, summed over nodes [s].
    """

    scores: Mapping[str, Scores]
    failed: str | None
    images: int
    seconds: float


class ScoreTable:
    """What the cameras of a study score on each episode by itself.

    Worlds, paths and noise follow from the episode alone, so a score is a function of camera and episode,
    and a table of them answers whoever asks. Rows that stand in the results folder already are taken over
    if they are of an equal study; a camera that failed by a defect is tried again.

    Parameters
    ----------
    plan
        The study.
    evaluate
        Its simulation.
    executor
        Where cameras are scored.
    results
        The results folder.
    states
        What its trainable tasks know; nobody learns here.
    """

    def __init__(
        self,
        plan: Plan,
        evaluate: Evaluator,
        executor: Executor,
        results: Results,
        states: Mapping[str, State] | None = None,
    ) -> None:
        self._fitness = plan.fitness
        self._evaluate = evaluate
        self._executor = executor
        self._results = results
        self._states = dict(states or {})
        self._study = _simulated(plan)
        self._rows: dict[str, TableRow] = {}
        kept = results.read_lines(FILE)
        results.write_lines(FILE, kept)  # a last line that was cut short goes
        for line in kept:
            if line["study"] == self._study:
                row = {name: line[name] for name in ("scores", "failed", "images", "seconds")}
                self._rows[line["key"]] = TableRow(**row)

    def __len__(self) -> int:
        return len(self._rows)

    @property
    def images(self) -> int:
        """Images rendered for all that is in it."""
        return sum(row.images for row in self._rows.values())

    def lacking(self, wanted: Iterable[Wanted]) -> list[Wanted]:
        """What is wanted and not in the table yet, each once."""
        by_key = {_key(values, spec): (values, spec) for values, spec in wanted}
        return [pair for key, pair in by_key.items() if key not in self._rows]

    def fill(self, wanted: Iterable[Wanted], on_row: Callable[[str], None] = lambda _: None) -> None:
        """Simulate what is wanted and not there, episode by episode, so that worlds are built once.

        Parameters
        ----------
        wanted
            Cameras and episodes.
        on_row
            Called with a short note as each row comes.
        """
        new = sorted(self.lacking(wanted), key=lambda pair: repr(pair[1]))  # a stable sort
        jobs = [ScoreJob(values, (spec,), self._states, partial=True) for values, spec in new]
        for (values, spec), evaluation in zip(new, self._executor.map(self._evaluate, jobs), strict=True):
            row, key = _row(evaluation), _key(values, spec)
            self._rows[key] = row
            if evaluation.raised is None:
                self._results.append_line(FILE, {"study": self._study, "key": key, **asdict(row)})
            on_row(row.failed or "")

    def row(self, values: Mapping[str, Any], spec: EpisodeSpec) -> TableRow:
        """A row that is there; KeyError where it is not."""
        return self._rows[_key(values, spec)]

    def evaluation(self, values: Mapping[str, Any], specs: Sequence[EpisodeSpec]) -> Evaluation:
        """What a study would have found for a camera on these episodes; all must be in the table."""
        return judged(values, [self.row(values, spec) for spec in specs], self._fitness)


def judged(values: Mapping[str, Any], rows: Sequence[TableRow], fitness: Any) -> Evaluation:
    """The evaluation of a camera from its rows; one may stand among them more than once."""
    return merged_evaluation([_evaluation(values, row) for row in rows], fitness)


def _evaluation(values: Mapping[str, Any], row: TableRow) -> Evaluation:
    alone = set(row.scores) == {""}
    return Evaluation(
        values=values,
        failed=row.failed,
        episodes=(row.scores[""],) if alone else (),
        scenario_episodes={} if alone else {name: (scores,) for name, scores in row.scores.items()},
        images=row.images,
        seconds={"all": row.seconds},
    )


def _row(evaluation: Evaluation) -> TableRow:
    columns = {name: episodes[0] for name, episodes in evaluation.scenario_episodes.items()}
    if evaluation.episodes:
        columns = {"": evaluation.episodes[0]}
    seconds = sum(evaluation.seconds.values())
    return TableRow(columns, evaluation.failed, evaluation.images, seconds)


def _key(values: Mapping[str, Any], spec: EpisodeSpec) -> str:
    return content_key(values, asdict(spec))


def _simulated(plan: Plan) -> str:
    """A name for what scores depend on in a recipe: those of another recipe are not taken for its own."""
    data = plan.recipe.as_data()
    searching = ("name", "notes", "design", "optimizer", "executor", "compare", "study", "test", "fitness")
    return content_key({key: value for key, value in data.items() if key not in searching})
