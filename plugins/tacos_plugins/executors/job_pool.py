"""Jobs for workers that may be lost: who gets which, what is tried again, in which order outcomes come."""

from __future__ import annotations

import logging
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Generic, TypeVar

from tacos_plugins.executors.affinity import Affinity, JobTimes, Making, affinity_of, assigned, making
from tacos_plugins.executors.outcomes import Lost
from tacos_plugins.executors.worker import Answer

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Task:
    """One job on its way: of which call of `JobPool.outcomes`, which of its jobs, tried how often."""

    round: int
    index: int
    attempt: int = 1


@dataclass(eq=False)
class PoolWorker:
    """A worker as its pool sees it."""

    ready: bool = False
    task: Task | None = None
    """Its task; None where it is idle."""
    at_hand: set[Affinity] = field(default_factory=set)
    """Needs of the jobs it has had, which it may have kept."""
    makes: Making = "nothing"
    began_s: float = 0.0
    """Things it had to make for its task, and the time it was given that [s]."""

    @property
    def idle(self) -> bool:
        """True if it waits for a job."""
        return self.ready and self.task is None

    def took(self, task: Task, needs: Affinity, anywhere: Collection[Affinity]) -> None:
        """It was given a task, while any worker had this at hand."""
        self.task = task
        self.makes, self.began_s = making(needs, self.at_hand, anywhere), time.monotonic()
        self.at_hand.add(needs)


Worker = TypeVar("Worker", bound=PoolWorker)


class JobPool(ABC, Generic[Worker]):
    """Workers that hold one function.

    - `workers`: how many at most.
    - `attempts`: how often a job is tried whose worker is lost or hangs.
    """

    def __init__(self, payload: bytes, workers: int, attempts: int) -> None:
        self.payload = payload
        self._most = workers
        self._attempts = attempts
        self._workers: list[Worker] = []
        self._times = JobTimes()
        self._round = 0
        self._waiting: deque[Task] = deque()
        self._done: dict[int, Answer | Lost] = {}

    def outcomes(self, jobs: Sequence[Any]) -> Iterator[Answer | Lost]:
        """One outcome for each job, in their order, each as soon as it and those before it are there.

        Raises `RuntimeError` when the pool is closed meanwhile, or workers end before they are ready for a
        first job.
        """
        self._round += 1  # what workers still do for a round that was left early is dropped when it comes
        self._waiting = deque(Task(self._round, index) for index in range(len(jobs)))
        self._done = {}
        for index in range(len(jobs)):
            while index not in self._done:
                self._hand_out(jobs)
                self._collect()
            self._hand_out(jobs)  # workers go on while the caller looks at this one
            yield self._done.pop(index)

    @abstractmethod
    def close(self) -> None:
        """End all workers at once."""

    @abstractmethod
    def _start(self) -> Worker:
        """A new worker, on its way to be ready."""

    @abstractmethod
    def _send(self, each: Worker, job: Any) -> bool:
        """Give an idle worker a job; False where it is dead already."""

    @abstractmethod
    def _collect(self) -> None:
        """Wait until something happens, and see to it."""

    def _hand_out(self, jobs: Sequence[Any]) -> None:
        """Give waiting tasks to idle workers, and start workers where too few are there."""
        idle = [each for each in self._workers if each.idle]
        wanted = [affinity_of(jobs[task.index]) for task in self._waiting] if idle else []
        busy = {each for other in self._workers if not other.idle for each in other.at_hand}
        given = assigned(wanted, [each.at_hand for each in idle], busy, self._times.cost_of_making)
        anywhere = busy.union(*(each.at_hand for each in idle))
        for each, task in [(idle[number], self._waiting[place]) for number, place in given.items()]:
            job = jobs[task.index]
            if self._send(each, job):
                each.took(task, affinity_of(job), anywhere)
                self._waiting.remove(task)
        starting = sum(not each.ready for each in self._workers)
        for _ in range(min(self._most - len(self._workers), len(self._waiting) - starting)):
            self._workers.append(self._start())

    def _finished(self, each: Worker, task: Task, answer: Answer) -> None:
        """Keep the answer of a worker, and how long it took."""
        self._times.saw(time.monotonic() - each.began_s, made=each.makes)
        if task.round == self._round:
            self._done[task.index] = answer

    def _try_again(self, task: Task | None, how: str) -> None:
        """Have a task tried again whose worker was lost, or give it up."""
        if task is None or task.round != self._round:
            return
        if task.attempt < self._attempts:
            log.warning("job %d: %s; it is tried again", task.index, how)
            self._waiting.appendleft(replace(task, attempt=task.attempt + 1))
        else:
            self._done[task.index] = Lost(f"{how}, {task.attempt} times in a row")
