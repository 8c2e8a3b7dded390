"""Scores of cameras on episodes: each pair is simulated once, whoever asks, and kept on disk as it comes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from tacos_framework import Evaluation, Executor, Fitness, Scores, State, content_key
from tacos_framework.plan import Plan
from tacos_framework.simulation import EpisodeSpec, Evaluator, Raised, ScoreJob, merged_evaluation
from tacos_framework.store import Results
from tacos_framework.study import broken_by

FILE = "scores.jsonl"
KEPT = ("scores", "failed", "images", "seconds")
"""What that file has of a row."""

Wanted = tuple[Mapping[str, Any], EpisodeSpec]
"""Plain values of a camera, and an episode to score it on."""


@dataclass(frozen=True)
class TableRow:
    """Scores of one camera in one episode."""

    scores: Mapping[str, Scores]
    """The scores in each scenario by its name, which is empty where there is only one."""
    failed: str | None  # why there are none, in a sentence
    images: int
    seconds: float  # time it took, summed over nodes [s]
    broken: Mapping[str, float] = field(default_factory=dict)  # by how much the camera breaks each constraint
    raised: Raised | None = None  # the defect behind `failed`, if it is one


class ScoreTable:
    """Scores of a study's cameras on each episode by itself.

    Worlds, paths and noise follow from the episode alone, so a score is a function of camera and episode,
    and a table of them answers whoever asks. Rows that stand in the results folder already are taken over
    if they are of an equal study; a camera that failed by a defect is tried again. One that breaks a
    constraint is not worth a row on disk: nothing is rendered for it.

    `states`: what its trainable tasks know; nobody learns here.
    """

    def __init__(
        self,
        plan: Plan,
        evaluate: Evaluator,
        executor: Executor,
        results: Results,
        states: Mapping[str, State] | None = None,
    ) -> None:
        self._plan = plan
        self._evaluate = evaluate
        self._executor = executor
        self._results = results
        self._states = dict(states or {})
        self._study = _simulated(plan)
        self._rows: dict[str, TableRow] = {}
        kept = results.read_lines(FILE)
        for line in kept:
            if line["study"] == self._study:
                self._rows[line["key"]] = TableRow(**{name: line[name] for name in KEPT})

    def __len__(self) -> int:
        return len(self._rows)

    @property
    def images(self) -> int:
        return sum(row.images for row in self._rows.values())

    @property
    def seconds(self) -> float:
        """Time that took, summed over nodes and workers [s]."""
        return sum(row.seconds for row in self._rows.values())

    def lacking(self, wanted: Iterable[Wanted]) -> list[Wanted]:
        by_key = {_key(values, spec): (values, spec) for values, spec in wanted}
        return [pair for key, pair in by_key.items() if key not in self._rows]

    def fill(self, wanted: Iterable[Wanted], on_row: Callable[[str], None] = lambda _: None) -> None:
        """Simulate what is wanted and not there, episode by episode, so that worlds are built once.

        `on_row`: called with a short note as each row comes.
        """
        new = []
        for values, spec in sorted(self.lacking(wanted), key=lambda pair: repr(pair[1])):  # a stable sort
            if broken_by(self._plan, values):
                refused = ScoreJob(values, (spec,)).run(self._evaluate.simulation)
                self._rows[_key(values, spec)] = _row(refused)
                on_row(refused.failed or "")
            else:
                new.append((values, spec))
        jobs = [ScoreJob(values, (spec,), self._states, partial=True) for values, spec in new]
        for (values, spec), evaluation in zip(new, self._executor.map(self._evaluate, jobs), strict=True):
            row, key = _row(evaluation), _key(values, spec)
            self._rows[key] = row
            if row.raised is None:
                self._results.append_line(FILE, {"study": self._study, "key": key, **_kept(row)})
            on_row(row.failed or "")

    def row(self, values: Mapping[str, Any], spec: EpisodeSpec) -> TableRow:
        """A row that is there; KeyError where it is not."""
        return self._rows[_key(values, spec)]

    def evaluation(self, values: Mapping[str, Any], specs: Sequence[EpisodeSpec]) -> Evaluation:
        return evaluation_of(values, [self.row(values, spec) for spec in specs], self._plan.fitness)


def evaluation_of(values: Mapping[str, Any], rows: Sequence[TableRow], fitness: Fitness) -> Evaluation:
    """The evaluation of a camera from its rows; one may stand among them more than once."""
    return merged_evaluation([_partial(values, row) for row in rows], fitness)


def _partial(values: Mapping[str, Any], row: TableRow) -> Evaluation:
    alone = set(row.scores) == {""}
    return Evaluation(
        values=values,
        failed=row.failed,
        episodes=(row.scores[""],) if alone else (),
        scenario_episodes={} if alone else {name: (scores,) for name, scores in row.scores.items()},
        images=row.images,
        seconds={"all": row.seconds},
        broken=row.broken,
        raised=row.raised,
    )


def _row(evaluation: Evaluation) -> TableRow:
    columns = {name: episodes[0] for name, episodes in evaluation.scenario_episodes.items()}
    if evaluation.episodes:
        columns = {"": evaluation.episodes[0]}
    seconds = sum(evaluation.seconds.values())
    images, broken, raised = evaluation.images, evaluation.broken, evaluation.raised
    return TableRow(columns, evaluation.failed, images, seconds, broken, raised)


def _kept(row: TableRow) -> dict[str, Any]:
    return {name: getattr(row, name) for name in KEPT}


def _key(values: Mapping[str, Any], spec: EpisodeSpec) -> str:
    return content_key(values, asdict(spec))


def _simulated(plan: Plan) -> str:
    """A name for what scores depend on in a recipe: those of another recipe are not taken for its own."""
    data = plan.recipe.as_data()
    searching = ("name", "notes", "design", "optimizer", "executor", "compare", "study", "test", "fitness")
    return content_key({key: value for key, value in data.items() if key not in searching})
