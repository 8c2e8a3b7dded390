"""One optimizer on one problem with one seed, and what it would have recommended after how many images."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

from tacos_framework import Evaluation, Executor, content_key
from tacos_framework.simulation import Evaluator, ScoreJob
from tacos_framework.study import Search
from tacos_validation.score_table import ScoreTable, Wanted

MOST_IDLE_ROUNDS = 50
"""After so many rounds in a row that render nothing, a run finds nothing new."""

BUDGET_SPENT = "budget spent"


class FromTable:
    """Answers the jobs of a search from a table, and has rendered what the table lacks.

    It stands where a study has its executor, so that a search here goes as it does in a study.
    """

    workers = 1

    def __init__(self, table: ScoreTable, fill: Callable[[Iterable[Wanted]], None]) -> None:
        self._table = table
        self._fill = fill
        self.seconds = 0.0

    def map(self, evaluate: Callable[[Any], Any], jobs: Sequence[ScoreJob]) -> Iterator[Evaluation]:
        """The evaluations of the jobs, each charged the images it takes whoever has had them rendered."""
        began = time.thread_time()
        self._fill([(job.values, spec) for job in jobs for spec in job.episodes])
        found = [self._table.evaluation(job.values, job.episodes) for job in jobs]
        self.seconds += time.thread_time() - began
        yield from found

    def close(self) -> None:
        """Nothing to let go of."""


@dataclass(frozen=True)
class Stand:
    """Recommendation of a run at a checkpoint."""

    checkpoint: int  # images it was allowed
    images: int  # images it had rendered when it said so
    values: Mapping[str, Any] | None  # the camera; None while nothing has been scored


@dataclass
class Run:
    """A run of an optimizer; `go` takes it to its end.

    Its recommendation at a checkpoint is the last it gives before it would render more images than that.
    An optimizer without a say in it, or that has not been asked yet, stands for the candidate of the best
    mean fitness so far, which it may have found in the middle of a round.
    """

    optimizer_name: str
    seed: int
    search: Search
    checkpoints: tuple[int, ...]  # in rising order; the last is the budget [images]
    target_rounds: int  # the round after which `after_rounds` is noted
    on_checkpoint: Callable[[str], None] = lambda _: None
    stands: list[Stand] = field(default_factory=list)
    after_rounds: Stand | None = None
    stopped: str = ""
    candidates: int = 0
    thought_seconds: float = 0.0
    _latest: Stand = Stand(0, 0, None)
    _has_recommended: bool = False
    _largest_round: int = 0
    _fitness: dict[str, list[float]] = field(default_factory=dict)

    def go(self, source: FromTable, evaluate: Evaluator) -> None:
        """Search until the budget is spent or the optimizer has stopped.

        Raises KeepsFailing when candidates fail one after the other by the same defect of a component.
        """
        idle = 0
        while not self.stopped:
            before, known = self.search.images, source.seconds
            began = time.thread_time()  # other runs think at the same time
            if before and self._recommends and before + self._largest_round > self._next_checkpoint:
                self._latest, self._has_recommended = self._recommendation(), True
            evaluations = self.search.step(cast("Executor", source), evaluate, lambda _: None)
            self.thought_seconds += time.thread_time() - began - (source.seconds - known)
            self._see(before, evaluations)
            idle = 0 if self.search.images > before else idle + 1
            self.stopped = self._stop(idle)
        if self.search.images <= self.checkpoints[-1]:
            self._latest = self._recommendation()
        self._pass_checkpoints(self.checkpoints[-1] + 1)

    @property
    def _next_checkpoint(self) -> int:
        return self.checkpoints[len(self.stands)]

    @property
    def _recommends(self) -> bool:
        return self.search.optimizer is not None and self.search.optimizer.recommends

    def _recommendation(self) -> Stand:
        return Stand(0, self.search.images, next(iter(self.search.most_promising(1)), None))

    def _see(self, before: int, evaluations: Iterable[Evaluation]) -> None:
        spent, best = before, max(map(_mean, self._fitness.values()), default=float("-inf"))
        for evaluation in evaluations:
            self.candidates += 1
            spent += evaluation.images
            self._pass_checkpoints(spent)
            if evaluation.fitness is None or self._has_recommended:
                continue
            own = self._fitness.setdefault(content_key(evaluation.values), [])
            own.append(evaluation.fitness)
            if _mean(own) > best:
                best, self._latest = _mean(own), Stand(0, spent, evaluation.values)
        self._largest_round = max(self._largest_round, spent - before)
        if self.search.generation == self.target_rounds:
            self.after_rounds = self._recommendation()

    def _pass_checkpoints(self, spent: int) -> None:
        for checkpoint in self.checkpoints[len(self.stands) :]:
            if checkpoint >= spent:
                return
            self.stands.append(replace(self._latest, checkpoint=checkpoint))
            self.on_checkpoint(f"{self.optimizer_name} {self.seed}: {checkpoint} images")

    def _stop(self, idle: int) -> str:
        if self.search.images >= self.checkpoints[-1]:
            return BUDGET_SPENT
        if idle >= MOST_IDLE_ROUNDS:
            return f"{idle} rounds in a row brought nothing that was not known"
        return self.search.stopped or ""


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)
