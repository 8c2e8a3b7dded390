"""Ray actors that may be lost with their nodes, and the results that come out of them all the same."""

from __future__ import annotations

import logging
import re
import time
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from multiprocessing.reduction import ForkingPickler
from typing import Any

from tacos_plugins.executors.affinity import Affinity, JobTimes, Making, affinity_of, assigned, making
from tacos_plugins.executors.on_ray.actor import EvaluatorActor
from tacos_plugins.executors.on_ray.cluster import Cluster, Needs
from tacos_plugins.executors.outcomes import Lost, Task
from tacos_plugins.executors.worker import Answer

log = logging.getLogger(__name__)

PATIENCE_S = 30.0
"""How long nothing may happen before it is looked at what is waited for [s]."""

STARTS = 3
"""Workers in a row that end before they are ready, after which the reason is not a lost node."""


@dataclass(eq=False)
class _Member:
    """An actor, and the one answer it owes: that it has started, or that to a job."""

    actor: Any
    owes: Any
    ready: bool = False
    task: Task | None = None
    deadline: float = float("inf")
    at_hand: set[Affinity] = field(default_factory=set)
    makes: Making = "nothing"
    began_s: float = 0.0


class ActorPool:
    """Actors that hold one function.

    Parameters
    ----------
    cluster
        Where they run.
    payload
        The pickled function.
    workers
        How many at most; those for which no node has room wait until one has.
    needs
        What each takes up.
    threads
        Threads each may compute with.
    attempts
        How often a job is tried whose worker is lost or hangs.
    job_s
        Longest time for one job; None for any [s].
    environment
        Environment variables they start with.
    """

    def __init__(
        self,
        cluster: Cluster,
        payload: bytes,
        *,
        workers: int,
        needs: Needs,
        threads: int,
        attempts: int,
        job_s: float | None,
        environment: Mapping[str, str],
    ) -> None:
        self.payload = payload
        self._ray = cluster.ray
        self._most = workers
        self._threads = threads
        self._attempts = attempts
        self._job_s = job_s
        self._actor_class = self._ray.remote(EvaluatorActor).options(
            num_cpus=needs.cpus,
            num_gpus=needs.gpus,
            max_restarts=0,  # a new actor is a new process on whichever node has room
            scheduling_strategy="SPREAD",
            runtime_env={"env_vars": dict(environment)},
        )
        self._payload_ref = self._ray.put(payload)  # once a node, whatever the number of workers
        self._members: list[_Member] = []
        self._times = JobTimes()
        self._failed_starts = 0
        self._round = 0
        self._closed = False

    def outcomes(self, jobs: Sequence[Any]) -> Iterator[Answer | Lost]:
        """One outcome for each job, in their order, each as soon as it and those before it are there.

        Raises
        ------
        RuntimeError
            When the pool is closed meanwhile, or workers end before they are ready for a first job.
        """
        self._round += 1  # what is still done for a round that was left early is dropped when it comes
        waiting = deque(Task(self._round, index) for index in range(len(jobs)))
        done: dict[int, Answer | Lost] = {}
        for index in range(len(jobs)):
            while index not in done:
                self._hand_out(jobs, waiting)
                self._collect(waiting, done)
            self._hand_out(jobs, waiting)  # workers go on while the caller looks at this one
            yield done.pop(index)

    def close(self) -> None:
        """End all workers at once."""
        self._closed = True
        for each in self._members:
            self._ray.kill(each.actor)
        self._members.clear()

    # ------------------------------------------------------------------------------------------------------

    def _hand_out(self, jobs: Sequence[Any], waiting: deque[Task]) -> None:
        """Give waiting tasks to idle workers, and ask for workers where too few are there."""
        idle = [each for each in self._members if each.ready and each.owes is None]
        wanted = [affinity_of(jobs[task.index]) for task in waiting] if idle else []
        busy = {each for other in self._members if other not in idle for each in other.at_hand}
        given = assigned(wanted, [each.at_hand for each in idle], busy, self._times.cost_of_making)
        anywhere = busy.union(*(each.at_hand for each in idle))
        for each, task in [(idle[number], waiting[place]) for number, place in given.items()]:
            waiting.remove(task)
            each.task = task
            needs = affinity_of(jobs[task.index])
            each.makes, each.began_s = making(needs, each.at_hand, anywhere), time.monotonic()
            each.at_hand.add(needs)
            each.owes = each.actor.answer.remote(bytes(ForkingPickler.dumps(jobs[task.index])))
            each.deadline = float("inf") if self._job_s is None else each.began_s + self._job_s
        starting = sum(not each.ready for each in self._members)
        for _ in range(min(self._most - len(self._members), len(waiting) - starting)):
            actor = self._actor_class.remote(self._payload_ref, self._threads)
            self._members.append(_Member(actor, actor.ready.remote()))

    def _collect(self, waiting: deque[Task], done: dict[int, Answer | Lost]) -> None:
        """Wait until something happens, and see to it."""
        owed = [each.owes for each in self._members if each.owes is not None]
        soonest = min((each.deadline for each in self._members), default=float("inf"))
        patience = max(0.0, min(PATIENCE_S, soonest - time.monotonic()))
        came, _ = self._ray.wait(owed, num_returns=1, timeout=patience)
        if self._closed:
            raise RuntimeError("the executor was closed while jobs were running")
        if not came and not any(each.ready for each in self._members):
            log.warning("no worker has started yet: the cluster has no room, or is starting nodes")
        for each in list(self._members):
            if each.owes is not None and each.owes in came:
                self._take(each, waiting, done)
            elif time.monotonic() > each.deadline:
                self._ray.kill(each.actor)
                self._replace(each, f"it took longer than {self._job_s:g} s", waiting, done)

    def _take(self, each: _Member, waiting: deque[Task], done: dict[int, Answer | Lost]) -> None:
        """Keep what a worker sent, or learn that it is lost."""
        try:
            message = self._ray.get(each.owes)
        except self._ray.exceptions.RayError as error:  # the worker, its node, or the answer itself is lost
            if not each.ready:
                self._note_failed_start(error)
            self._replace(each, _how(error), waiting, done)
            return
        task, each.task, each.owes, each.deadline = each.task, None, None, float("inf")
        if task is None:
            each.ready, self._failed_starts = True, 0
            return
        self._times.saw(time.monotonic() - each.began_s, made=each.makes)
        if task.round == self._round:
            done[task.index] = ForkingPickler.loads(message)

    def _replace(self, each: _Member, how: str, waiting: deque[Task], done: dict[int, Answer | Lost]) -> None:
        """Forget a worker that is lost; try its job again, or give it up."""
        self._members.remove(each)
        self._ray.kill(each.actor)  # where only the connection to it was lost
        task = each.task
        if task is None or task.round != self._round:
            return
        if task.attempt < self._attempts:
            log.warning("job %d: %s; it is tried again", task.index, how)
            waiting.appendleft(replace(task, attempt=task.attempt + 1))
        else:
            done[task.index] = Lost(f"{how}, {task.attempt} times in a row")

    def _note_failed_start(self, error: Exception) -> None:
        self._failed_starts += 1
        if self._failed_starts >= STARTS:
            refusal = RuntimeError(f"workers cannot start: {_how(error)}")
            refusal.add_note("Every node needs tacos-framework and the plugins of the recipe installed.")
            raise refusal from error


def _how(error: Exception) -> str:
    """How a worker was lost, in a few words out of Ray's many.

    Examples
    --------
    >>> _how(Exception("The actor died.\\nThe actor is dead because its node has died. Node Id: 1f"))
    'its node has died'
    """
    found = re.search(r"The actor is dead because (?:the |all references )?([^.\n]+)", str(error))
    return found[1].strip() if found else f"its worker was lost ({type(error).__name__})"
