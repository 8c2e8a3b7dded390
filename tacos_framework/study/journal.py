"""Evaluations since the last checkpoint, job by job, so that a killed study need not repeat them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, replace
from typing import Any, ClassVar, TypeVar

import numpy as np

from tacos_framework.cache import content_key
from tacos_framework.contracts import Executor, ExecutorBase, State, optional
from tacos_framework.settings import Settings
from tacos_framework.simulation import Evaluation, ScoreJob
from tacos_framework.store import Results
from tacos_framework.study.kept_evaluation import as_data, evaluation_from
from tacos_framework.study.run_files import KeptJob, checked_type

EVALUATIONS = "evaluations"
"""Kind of their entries in the database of the run."""

MOST_BYTES = 2 * 2**30
"""Weights kept with them [bytes]; what candidates learn beyond that is learnt again after a kill."""

Job = TypeVar("Job")
Result = TypeVar("Result")


class Journal:
    """The evaluations since the last checkpoint, by what was evaluated.

    An evaluation follows from its job alone, so it does not matter in which order a resumed study asks for
    jobs again, or whether it asks for all of them: what is not in the journal is evaluated.

    - `seconds`: gives the time the study has taken so far [s], which is kept with each.
    """

    def __init__(self, results: Results, seconds: Callable[[], float]) -> None:
        self._results, self._seconds = results, seconds
        self._bytes = 0
        self._keys_of_states: list[tuple[State, str]] = []

    def entries(self) -> list[KeptJob]:
        """Journal of a run.

        Raises `UserError` when it is no list of evaluations.
        """
        with self._results.database() as database:
            return [
                checked_type(KeptJob, database.path, f"{EVALUATIONS} {key}", value)
                for key, value in database.all(EVALUATIONS).items()
            ]

    def find(self, job: ScoreJob) -> Evaluation | None:
        """The outcome of a job, if it is known."""
        with self._results.database() as database:
            kept = database.get(EVALUATIONS, self._key(job))
        if kept is None:
            return None
        states = {task: self._results.read_state(name) for task, name in kept["weights"].items()}
        return replace(evaluation_from(kept["evaluation"]), states=states)

    def add(self, job: ScoreJob, evaluation: Evaluation) -> None:
        """Keep what came out; not where a defect did, which may be mended when the study goes on."""
        size = sum(
            np.asarray(array).nbytes for state in evaluation.states.values() for array in state.values()
        )
        if evaluation.raised is not None or self._bytes + size > MOST_BYTES:
            return
        self._bytes += size
        key = self._key(job)
        weights = {task: f"journal.{task}.{key}" for task in evaluation.states}
        with self._results.transaction() as database:
            for task, state in evaluation.states.items():
                self._results.write_state(weights[task], state)
            kept = {
                "seconds": round(self._seconds(), 3),
                "evaluation": as_data(evaluation),
                "weights": weights,
            }
            database.put(EVALUATIONS, key, kept)

    def clear(self) -> None:
        """Forget everything, as a checkpoint has it now."""
        self._bytes = 0
        with self._results.database() as database:
            database.remove(EVALUATIONS)

    def _key(self, job: ScoreJob) -> str:
        states = {task: self._key_of(state) for task, state in job.states.items()}
        training = job.training and asdict(job.training)
        return content_key(job.values, [asdict(spec) for spec in job.episodes], states, training, job.partial)

    def _key_of(self, state: State) -> str:
        """Content key of what a task knows; of the last few states it is remembered, as weights are large."""
        for known, key in self._keys_of_states:
            if known is state:
                return key
        key = content_key({name: np.asarray(array) for name, array in state.items()})
        self._keys_of_states = [*self._keys_of_states[-7:], (state, key)]
        return key


class JournaledExecutor:
    """An executor that does not run again what the journal has, and has the journal told of all it runs.

    - `journal`: what is known, and where what comes out is written down.
    """

    Config: ClassVar[type[Settings]] = Settings

    def __init__(self, executor: Executor, journal: Journal) -> None:
        self._executor, self._journal = executor, journal

    @property
    def workers(self) -> int:
        return int(optional(self._executor, ExecutorBase, "workers"))

    def map(self, evaluate: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        """The results in the order of the jobs; each is written down before it is handed on."""
        known = {i: found for i, job in enumerate(jobs) if (found := self._known(job)) is not None}
        rest = iter(self._executor.map(evaluate, [job for i, job in enumerate(jobs) if i not in known]))
        for i, job in enumerate(jobs):
            if i in known:
                yield known.pop(i)
                continue
            result = next(rest)
            if isinstance(job, ScoreJob) and isinstance(result, Evaluation):
                self._journal.add(job, result)
            yield result
        for _ in rest:  # to the end: there an executor cleans up, and one that gives too many is found out
            pass

    def _known(self, job: Any) -> Any:
        return self._journal.find(job) if isinstance(job, ScoreJob) else None

    def close(self) -> None:
        self._executor.close()
