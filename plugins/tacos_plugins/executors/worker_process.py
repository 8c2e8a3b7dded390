"""A worker process as the process that started it sees it."""

from __future__ import annotations

import signal
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.reduction import ForkingPickler
from typing import Any

from tacos_plugins.executors import worker
from tacos_plugins.executors.job_pool import PoolWorker
from tacos_plugins.executors.worker_logs import WorkerLog, explicit_levels


class WorkerProcess(PoolWorker):
    """A process that evaluates one job at a time.

    - `number`: counts the workers of a pool from 1; their log lines bear it.
    - `context`: how processes are started.
    """

    def __init__(self, number: int, context: SpawnContext, payload: bytes, threads: int) -> None:
        super().__init__()
        self.channel, theirs = context.Pipe()
        logs, their_logs = context.Pipe(duplex=False)
        self.process: SpawnProcess = context.Process(
            target=worker.serve,
            args=(payload, theirs, threads, their_logs, explicit_levels()),
            name=f"tacos-worker-{number}",
        )
        self.process.start()
        theirs.close()  # so that the channel breaks when the worker dies
        their_logs.close()
        self.log = WorkerLog(logs, f"worker {number}")
        self.jobs_done = 0

    def send(self, job: Any) -> bool:
        """Send a job; False when the worker is dead already."""
        message = bytes(ForkingPickler.dumps(job))
        try:
            self.channel.send_bytes(message)
        except (BrokenPipeError, ConnectionResetError):
            return False
        return True

    def answer(self) -> bytes | None:
        """Its next message, if there is one.

        Raises `EOFError` or `ConnectionResetError` when it is dead.
        """
        if self.channel.poll():
            return self.channel.recv_bytes()
        if not self.process.is_alive() and not self.channel.poll():
            raise EOFError
        return None

    def how_it_ended(self) -> str:
        self.process.join()
        return f"its worker process {ending_in_words(self.process.exitcode or 0)}"


def ending_in_words(code: int) -> str:
    """The end of a process by its exit code, negative for a signal.

    >>> ending_in_words(3), ending_in_words(-15)
    ('ended with status 3', 'was ended by SIGTERM')
    """
    if code >= 0:
        return f"ended with status {code}"
    name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
    out_of_memory = " (most often because memory ran out)" if -code == signal.SIGKILL else ""
    return f"was ended by {name}{out_of_memory}"
