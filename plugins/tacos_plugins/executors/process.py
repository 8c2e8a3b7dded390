"""Evaluation in worker processes of this machine."""

from __future__ import annotations

from tacos_framework import Settings, setting, usable_cores
from tacos_plugins.executors.pool import Limits, Pool
from tacos_plugins.executors.pool_executor import PoolExecutor

THREAD_LIMITS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "LP_NUM_THREADS")
"""Environment variables that numerical libraries and the llvmpipe rasterizer read once, when they start."""

MEMORY_IS_KEPT = {"MALLOC_MMAP_MAX_": "0", "MALLOC_TRIM_THRESHOLD_": str(2**31)}
"""Lets the C library (glibc) keep what is freed, up to 2 GiB, for the next image: to get the memory of one of
twelve megapixels anew from the system takes about as long as to fill it several times."""


class ProcessExecutor(PoolExecutor):
    """Evaluates jobs in processes that live until `close`, with the same results as in this process.

    Workers are *spawned*: a process that owns a GL context must not fork. Each receives the pickled
    ``evaluate`` once, and keeps it, with whatever it caches, for all jobs to come; a different ``evaluate``
    gets fresh workers. Each worker computes with a few threads only, so that workers do not fight for cores.

    A worker that dies (a driver crashes, memory runs out) or takes longer than ``timeout_s`` is replaced and
    its job tried once more. When that fails too, the result is ``evaluate.lost(job, reason)``, or a `JobLost`
    is raised where ``evaluate`` has no such method. The other jobs go on meanwhile.

    `close`, Ctrl-C and the death of this process end all workers at once, whatever they are doing.

    >>> executor = ProcessExecutor(ProcessExecutor.Config(workers=2))
    >>> list(executor.map(abs, [-1, 2, -3]))
    [1, 2, 3]
    >>> executor.close()
    """

    class Config(Settings):
        workers: int | None = setting(
            None,
            help="Worker processes; by default one for each core this process may use.",
            ge=1,
            also=("jobs", "processes"),
        )
        threads: int = setting(1, help="Threads each worker may compute with.", ge=1)
        timeout_s: float | None = setting(
            None,
            help="Longest time for one candidate, worlds built for it included; .inf for any. By default "
            "20 times the longest seen so far, and a minute more; ten times that when it is tried again. "
            "A worker that takes longer is replaced, and the candidate tried once more.",
            unit="s",
            gt=0,
        )
        max_memory_mib: int | None = setting(
            None,
            help="Memory a worker may hold after a candidate; one that holds more is replaced.",
            unit="MiB",
            ge=1,
        )
        tasks_per_worker: int | None = setting(
            None, help="Candidates after which a worker is replaced, for components that leak.", ge=1
        )

    def __init__(self, config: Config) -> None:
        super().__init__()
        self.config = config
        self.workers = config.workers or usable_cores()

    def _new_pool(self, payload: bytes) -> Pool:
        config = self.config
        limits = Limits(config.timeout_s, config.max_memory_mib, config.tasks_per_worker)
        threads = dict.fromkeys(THREAD_LIMITS, str(config.threads))
        return Pool(payload, self.workers, limits, config.threads, {**MEMORY_IS_KEPT, **threads})
