"""Functions that worker processes import; they cannot live in a test module."""

from __future__ import annotations

import logging
import os
import signal
import time
import warnings
from dataclasses import dataclass, field
from pathlib import Path

from tacos_framework.errors import Fault, UserError


def square(x: int) -> int:
    return x * x


def slow_square(x: int) -> int:
    time.sleep(0.05 * (3 - x % 4))
    return x * x


def fail_at_two(x: int) -> int:
    if x == 2:
        error = UserError(Fault("job 2", "is two"))
        error.add_note("while testing")
        raise error
    return x


def die(_: int) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def process_id(_: int) -> int:
    return os.getpid()


def give_a_generator(_: int) -> object:
    return (x for x in ())


class TwoArguments(Exception):
    def __init__(self, first: str, second: str) -> None:
        super().__init__(f"{first} {second}")


def raise_what_does_not_come_back(_: int) -> None:
    raise TwoArguments("one", "two")


def threads(_: int) -> tuple[str | None, str | None, int]:
    import cv2

    return os.environ.get("OMP_NUM_THREADS"), os.environ.get("LP_NUM_THREADS"), cv2.getNumThreads()


@dataclass
class Counting:
    """Leaves a file whenever it is unpickled, and keeps a count between calls."""

    folder: Path
    calls: int = field(default=0)

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state)
        (self.folder / f"{os.getpid()}-{time.monotonic_ns()}").touch()

    def __call__(self, _: int) -> int:
        self.calls += 1
        return self.calls


@dataclass(frozen=True)
class Hang:
    """Notes its process id in a folder, then sleeps for a minute."""

    folder: Path

    def __call__(self, _: int) -> None:
        (self.folder / str(os.getpid())).touch()
        time.sleep(60)


@dataclass(frozen=True)
class DieOnFirstAttempt:
    """Squares, but the first process that comes to `at` is killed; it leaves a file in a folder."""

    folder: Path
    at: int

    def __call__(self, x: int) -> int:
        if x == self.at and not any(self.folder.iterdir()):
            (self.folder / str(os.getpid())).touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return x * x


class _Squares:
    """Squares, and has an answer for jobs that are lost."""

    def __call__(self, x: int) -> int:
        return x * x

    def lost(self, x: int, reason: str) -> str:
        return f"{x} lost: {reason}"


@dataclass(frozen=True)
class DieAt(_Squares):
    """Squares, but every process that comes to `at` ends there."""

    at: int
    how: str

    def __call__(self, x: int) -> int:
        if x == self.at:
            if self.how == "exit":
                os._exit(3)
            os.kill(os.getpid(), {"killed": signal.SIGKILL, "segfault": signal.SIGSEGV}[self.how])
        return super().__call__(x)


@dataclass(frozen=True)
class HangAt(_Squares):
    """Squares, but sleeps for a minute at `at`."""

    at: int

    def __call__(self, x: int) -> int:
        if x == self.at:
            time.sleep(60)
        return super().__call__(x)


@dataclass(frozen=True)
class Visit:
    """A job that says what it needs."""

    affinity: str


def process_id_later(_: Visit) -> int:
    time.sleep(0.02)
    return os.getpid()


def say(x: int) -> int:
    """Logs a line of each level, and has Python warn."""
    log = logging.getLogger("tests.executors.jobs")
    log.debug("debug %d", x)
    log.info("info %d", x)
    try:
        raise ValueError("deep")
    except ValueError:
        log.exception("error %d", x, extra={"cannot_travel": lambda: None})
    warnings.warn(f"warned {x}", RuntimeWarning, stacklevel=1)
    return x


def say_and_die(_: int) -> None:
    logging.getLogger("tests.executors.jobs").error("last words")
    os.kill(os.getpid(), signal.SIGKILL)
