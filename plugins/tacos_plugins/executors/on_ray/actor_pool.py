"""Ray actors that may be lost with their nodes, and the results that come out of them all the same."""

from __future__ import annotations

import logging
import re
import time
from collections.abc import Mapping
from multiprocessing.reduction import ForkingPickler
from typing import Any

from tacos_plugins.executors.job_pool import JobPool, PoolWorker
from tacos_plugins.executors.on_ray.actor import EvaluatorActor
from tacos_plugins.executors.on_ray.cluster import Cluster, Needs

log = logging.getLogger(__name__)

PATIENCE_S = 30.0
"""Interval after which a silent job is looked at [s]."""

STARTS = 3
"""Workers in a row that end before they are ready, after which the reason is not a lost node."""


class _Member(PoolWorker):
    """An actor, and the one answer it owes: that it has started, or that to a job."""

    def __init__(self, actor: Any) -> None:
        super().__init__()
        self.actor = actor
        self.owes: Any = actor.ready.remote()


class ActorPool(JobPool[_Member]):
    """Actors that hold one function.

    - `workers`: how many at most; those for which no node has room wait until one has.
    - `needs`: what each takes up.
    - `attempts`: how often a job is tried whose worker is lost or hangs.
    - `job_s`: longest time for one job; None for any [s].
    - `environment`: environment variables they start with.
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
        super().__init__(payload, workers, attempts)
        self._ray = cluster.ray
        self._threads = threads
        self._job_s = job_s
        self._actor_class = self._ray.remote(EvaluatorActor).options(
            num_cpus=needs.cpus,
            num_gpus=needs.gpus,
            max_restarts=0,  # a new actor is a new process on whichever node has room
            scheduling_strategy="SPREAD",
            runtime_env={"env_vars": dict(environment)},
        )
        self._payload_ref = self._ray.put(payload)  # once a node, whatever the number of workers
        self._failed_starts = 0
        self._closed = False

    def close(self) -> None:
        self._closed = True
        for each in self._workers:
            self._ray.kill(each.actor)
        self._workers.clear()

    # ------------------------------------------------------------------------------------------------------

    def _start(self) -> _Member:
        return _Member(self._actor_class.remote(self._payload_ref, self._threads))

    def _send(self, each: _Member, job: Any) -> bool:
        each.owes = each.actor.answer.remote(bytes(ForkingPickler.dumps(job)))
        return True  # of one that is dead, the answer says so

    def _deadline(self, each: _Member) -> float:
        """When a worker counts as hung [s]."""
        return float("inf") if each.task is None or self._job_s is None else each.began_s + self._job_s

    def _collect(self) -> None:
        owed = [each.owes for each in self._workers if each.owes is not None]
        soonest = min((self._deadline(each) for each in self._workers), default=float("inf"))
        patience = max(0.0, min(PATIENCE_S, soonest - time.monotonic()))
        came, _ = self._ray.wait(owed, num_returns=1, timeout=patience)
        if self._closed:
            raise RuntimeError("the executor was closed while jobs were running")
        if not came and not any(each.ready for each in self._workers):
            log.warning("no worker has started yet: the cluster has no room, or is starting nodes")
        for each in list(self._workers):
            if each.owes is not None and each.owes in came:
                self._take(each)
            elif time.monotonic() > self._deadline(each):
                self._ray.kill(each.actor)
                self._replace(each, f"it took longer than {self._job_s:g} s")

    def _take(self, each: _Member) -> None:
        """Keep what a worker sent, or learn that it is lost."""
        try:
            message = self._ray.get(each.owes)
        except self._ray.exceptions.RayError as error:  # the worker, its node, or the answer itself is lost
            if not each.ready:
                self._note_failed_start(error)
            self._replace(each, _how(error))
            return
        task, each.task, each.owes = each.task, None, None
        if task is None:
            each.ready, self._failed_starts = True, 0
            return
        self._finished(each, task, ForkingPickler.loads(message))

    def _replace(self, each: _Member, how: str) -> None:
        """Forget a worker that is lost; try its job again, or give it up."""
        self._workers.remove(each)
        self._ray.kill(each.actor)  # where only the connection to it was lost
        self._try_again(each.task, how)

    def _note_failed_start(self, error: Exception) -> None:
        self._failed_starts += 1
        if self._failed_starts >= STARTS:
            refusal = RuntimeError(f"workers cannot start: {_how(error)}")
            refusal.add_note("Every node needs tacos-framework and the plugins of the recipe installed.")
            raise refusal from error


def _how(error: Exception) -> str:
    """The loss of a worker, in a few words out of Ray's many.

    >>> _how(Exception("The actor died.\\nThe actor is dead because its node has died. Node Id: 1f"))
    'its node has died'
    """
    found = re.search(r"The actor is dead because (?:the |all references )?([^.\n]+)", str(error))
    return found[1].strip() if found else f"its worker was lost ({type(error).__name__})"
