"""Evaluation on a Ray cluster, of one machine or of many."""

from __future__ import annotations

import math
import os
import sys

from tacos_framework import Settings, setting, usable_cores
from tacos_plugins.executors.on_ray.actor_pool import ActorPool
from tacos_plugins.executors.on_ray.cluster import LOCAL, Cluster, Needs
from tacos_plugins.executors.pool_executor import PoolExecutor
from tacos_plugins.executors.process import THREAD_LIMITS


class RayExecutor(PoolExecutor):
    """Evaluates jobs in Ray actors, with the same results as in this process.

    Each worker is an actor: a process of its own (so one GL context each, and none is forked), on whichever
    node has the processors and GPUs it needs. It receives the pickled ``evaluate`` once and keeps it, with
    whatever it caches, for all jobs to come. Jobs carry their seeds with them, so neither the number of
    workers nor where they run changes a result.

    A job whose worker, node or answer is lost is tried again by another worker, ``attempts`` times in all;
    then the result is ``evaluate.lost(job, reason)``, or a `JobLost` is raised where ``evaluate`` has no such
    method. The other jobs go on meanwhile. Nodes may join while a study runs, up to ``workers``.

    A cluster of our own listens on the loopback interface alone, has no dashboard, and ends with `close` or
    with this process. No usage statistics are sent.

    Source: Moritz et al. 2018, "Ray: A distributed framework for emerging AI applications", OSDI.

    As a recipe says it::

        executor: {use: executor.ray, address: auto, gpus_per_worker: 0.5}
    """

    class Config(Settings):
        address: str = setting(
            LOCAL,
            help="The cluster: local starts one on this machine for the run; auto joins the one that "
            "'ray start' began here or RAY_ADDRESS names; else host:port of its head.",
            min_length=1,
        )
        workers: int | None = setting(
            None, help="Workers at most; by default as many as the cluster has room for when it is joined.",
            ge=1, also=("jobs", "processes"))  # fmt: skip
        cpus_per_worker: float = setting(1.0, help="Processors each worker takes up.", gt=0)
        gpus_per_worker: float = setting(
            0.0,
            help="GPUs each worker takes up, as a share where several use one; with 0 torch sees none.",
            ge=0,
        )
        threads: int | None = setting(
            None, help="Threads each worker may compute with; by default cpus_per_worker, rounded up.", ge=1
        )
        attempts: int = setting(
            3, help="Attempts at a candidate whose worker or node is lost, or that takes too long.",
            ge=1,
        )  # fmt: skip
        timeout_s: float | None = setting(
            None,
            help="Longest time for one candidate, worlds built for it included; by default any.",
            unit="s",
            gt=0,
        )

    def __init__(self, config: Config) -> None:
        super().__init__()
        self.config = config
        self._needs = Needs(config.cpus_per_worker, config.gpus_per_worker)
        self._cluster: Cluster | None = None
        self._workers = config.workers or 0

    @property
    def workers(self) -> int:
        """Largest number of workers; joins the cluster to see.

        Raises `UserError` when no cluster answers, or it has no room for a worker.
        """
        self._joined()
        return self._workers

    def close(self) -> None:
        """End all workers at once, and the cluster if it is our own."""
        super().close()
        cluster, self._cluster = self._cluster, None
        if cluster is not None:
            cluster.leave()

    def _joined(self) -> Cluster:
        if self._cluster is None:
            cores = usable_cores()
            wanted = max(cores, int(self._needs.cpus * (self.config.workers or 0)))
            cluster = Cluster(self.config.address, wanted)
            try:
                room = cluster.room_for(self._needs)
            except BaseException:
                cluster.leave()
                raise
            self._cluster, self._workers = cluster, self.config.workers or room
        return self._cluster

    def _new_pool(self, payload: bytes) -> ActorPool:
        config = self.config
        threads = config.threads or math.ceil(config.cpus_per_worker)
        return ActorPool(
            self._joined(),
            payload,
            workers=self.workers,
            needs=self._needs,
            threads=threads,
            attempts=config.attempts,
            job_s=config.timeout_s,
            environment={**dict.fromkeys(THREAD_LIMITS, str(threads)), **self._import_paths()},
        )

    def _import_paths(self) -> dict[str, str]:
        """Workers of our own cluster import from where this process does; other nodes have theirs."""
        if self.config.address != LOCAL:
            return {}
        return {"PYTHONPATH": os.pathsep.join(path for path in sys.path if os.path.isdir(path))}
