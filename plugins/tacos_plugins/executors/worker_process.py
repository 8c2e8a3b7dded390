"""A worker process as the process that started it sees it."""

from __future__ import annotations

import signal
import time
from collections.abc import Collection
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.reduction import ForkingPickler
from typing import Any

from tacos_plugins.executors import worker
from tacos_plugins.executors.affinity import Affinity, Making, affinity_of, making
from tacos_plugins.executors.outcomes import Task
from tacos_plugins.executors.worker_logs import WorkerLog, explicit_levels


class WorkerProcess:
    """A process that evaluates one job at a time.

    Parameters
    ----------
    number
        Counts the workers of a pool from 1; their log lines bear it.
    context
        How processes are started.
    payload
        The pickled function.
    lifeline
        Reading end of a pipe that breaks when the pool is closed.
    threads
        Threads it may compute with.
    """

    def __init__(
        self, number: int, context: SpawnContext, payload: bytes, lifeline: Connection, threads: int
    ) -> None:
        self.channel, theirs = context.Pipe()
        logs, their_logs = context.Pipe(duplex=False)
        self.process: SpawnProcess = context.Process(
            target=worker.serve,
            args=(payload, theirs, lifeline, threads, their_logs, explicit_levels()),
            name=f"tacos-worker-{number}",
        )
        self.process.start()
        theirs.close()  # so that the channel breaks when the worker dies
        their_logs.close()
        self.log = WorkerLog(logs, f"worker {number}")
        self.ready = False
        self.task: Task | None = None
        self.jobs_done = 0
        self.at_hand: set[Affinity] = set()
        self.makes: Making = "nothing"
        self.began_s = 0.0

    @property
    def idle(self) -> bool:
        return self.ready and self.task is None

    def begin(self, task: Task, job: Any, anywhere: Collection[Affinity]) -> bool:
        """Send a job, told what any worker has; False when the worker is dead already."""
        message = bytes(ForkingPickler.dumps(job))
        try:
            self.channel.send_bytes(message)
        except (BrokenPipeError, ConnectionResetError):
            return False
        self.task = task
        self.makes, self.began_s = making(affinity_of(job), self.at_hand, anywhere), time.monotonic()
        self.at_hand.add(affinity_of(job))
        return True

    def answer(self) -> bytes | None:
        """What it has sent, if anything.

        Raises
        ------
        EOFError, ConnectionResetError
            When it is dead.
        """
        if self.channel.poll():
            return self.channel.recv_bytes()
        if not self.process.is_alive() and not self.channel.poll():
            raise EOFError
        return None

    def how_it_ended(self) -> str:
        """How the process ended, in words."""
        self.process.join()
        code = self.process.exitcode or 0
        if code >= 0:
            return f"its worker process ended with status {code}"
        name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
        out_of_memory = " (most often because memory ran out)" if -code == signal.SIGKILL else ""
        return f"its worker process was ended by {name}{out_of_memory}"
