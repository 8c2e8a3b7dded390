"""Results matched to jobs by key, whatever an executor makes of their order."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from typing import Any, ClassVar, Generic, TypeVar

from tacos_framework.contracts import ExecutorBase, JobRunner, optional
from tacos_framework.errors import ContractBroken
from tacos_framework.plugins.guarded import Culprit, blame
from tacos_framework.settings import Settings

Job = TypeVar("Job")
Result = TypeVar("Result")


@dataclass(frozen=True)
class Keyed(Generic[Job]):
    """A job on its way to an executor, or its result on the way back, with the key that belongs to both."""

    key: tuple[int, int]
    value: Job

    @property
    def affinity(self) -> Hashable | None:
        """Affinity of the job (`JobRunner`)."""
        found: Hashable | None = getattr(self.value, "affinity", None)
        return found


class EvaluateKeyed(Generic[Job, Result]):
    """Evaluates jobs with a key to results with that key. Can be pickled if what it calls can."""

    def __init__(self, evaluate: Callable[[Job], Result]) -> None:
        self.evaluate = evaluate

    def __call__(self, job: Keyed[Job]) -> Keyed[Result]:
        """The result, under the key of its job."""
        try:
            return Keyed(job.key, self.evaluate(job.value))
        except Exception as error:
            error.__dict__[_OF_A_JOB] = True
            raise

    @property
    def lost(self) -> Callable[[Keyed[Job], str], Keyed[Result]]:
        """The result of a lost job; absent if `evaluate` has no answer to that."""
        lost: Callable[[Job, str], Result] = self.evaluate.lost  # type: ignore[attr-defined]
        return lambda job, reason: Keyed(job.key, lost(job.value, reason))


_OF_A_JOB = "tacos_of_a_job"
"""Marks errors that a job raised: those are none of the executor's."""

_rounds = count()
"""Tells the jobs of one call from those of any other, whose results may still be on their way."""


def map_by_key(
    executor: JobRunner, evaluate: Callable[[Job], Result], jobs: Sequence[Job], name: str
) -> Iterator[Result]:
    """The results in the order of the jobs, each as soon as it and those before it are there.

    `executor`: runs the jobs, and hands the results on in whatever order. `name`: the executor as errors call
    it.

    Raises `ContractBroken` when the executor gives a result twice, one that belongs to no job, or none for a
    job. What a job raised leaves it unchanged.
    """
    early: dict[int, Result] = {}
    done, this_round = 0, next(_rounds)
    given = executor.map(EvaluateKeyed(evaluate), [Keyed((this_round, i), job) for i, job in enumerate(jobs)])
    for keyed in _iterated(given, name):
        if not isinstance(keyed, Keyed):
            raise ContractBroken(f"{name} gives {_short(keyed)} where the result of a job is expected")
        of_round, index = keyed.key
        if of_round != this_round:
            raise ContractBroken(f"{name} gives a result that belongs to none of the jobs it was given")
        if index < done or index in early:
            raise ContractBroken(f"{name} gives the result of job {index + 1} of {len(jobs)} twice")
        early[index] = keyed.value
        while done in early:
            yield early.pop(done)
            done += 1
    if missing := [str(index + 1) for index in range(done, len(jobs)) if index not in early]:
        some = ", ".join(missing[:5]) + (", ..." if len(missing) > 5 else "")
        raise ContractBroken(f"{name} gives no result for {len(missing)} of {len(jobs)} jobs: {some}")


def _iterated(given: Any, name: str) -> Iterator[Any]:
    try:
        return iter(given)
    except TypeError:
        raise ContractBroken(f"{name} gives {_short(given)} where results are expected, one a job") from None


def _short(given: Any) -> str:
    text = repr(given)
    return text if len(text) <= 60 else f"a {type(given).__name__}"


class GuardedExecutor:
    """An executor whose results come in the order of the jobs, and whose own errors name it.

    - `executor`: the executor of a recipe or of a host.
    - `use`: the component; None for one of the host's own, which is called by its class.
    """

    Config: ClassVar[type[Settings]] = Settings

    def __init__(self, executor: JobRunner, use: str | None = None, distribution: str | None = None) -> None:
        self._executor = executor
        self._culprit = Culprit(use or f"the executor {type(executor).__name__}", distribution)

    @classmethod
    def of_host(cls, executor: JobRunner) -> GuardedExecutor:
        """The executor a host hands over, which may be guarded already."""
        return executor if isinstance(executor, cls) else cls(executor)

    @property
    def workers(self) -> int:
        return int(optional(self._executor, ExecutorBase, "workers"))

    def map(self, evaluate: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        try:
            yield from map_by_key(self._executor, evaluate, jobs, str(self._culprit))
        except Exception as error:
            if not getattr(error, _OF_A_JOB, False):
                blame(error, self._culprit)
            raise

    def close(self) -> None:
        try:
            self._executor.close()
        except Exception as error:
            blame(error, self._culprit)
            raise


@contextmanager
def executor_of_run(
    host: JobRunner | None, make: Callable[[], JobRunner], use: str, distribution: str | None
) -> Iterator[GuardedExecutor]:
    """The executor of a host, which stays open, or else that of a recipe, made here and closed at the end.

    `host`: an executor that stands for the recipe's; None for none. `make`, `use`, `distribution`: makes the
    recipe's; the component it is, and where that comes from.
    """
    if host is not None:
        yield GuardedExecutor.of_host(host)
        return
    own = GuardedExecutor(make(), use, distribution)
    try:
        yield own
    finally:
        own.close()
