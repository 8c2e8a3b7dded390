"""Runs a toy study in processes that die; a script, so that its children can be forked from one import.

``python dying.py each DIR STRIDE``
    dies at a file operation or a statement to the database and is resumed, for every STRIDE-th of them,
    in DIR/0, DIR/STRIDE, ...
``python dying.py random DIR SEED KILLS``
    is killed again and again at random moments, and resumed each time, in DIR/killed

Both leave the unbroken run in DIR/whole.
"""

from __future__ import annotations

import os
import random
import shutil
import signal
import sqlite3
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import toy_plugin
from toy_study import LEARNER, run, toy_recipe

from tacos_framework.plugins import Plugins
from tacos_plugins.plugin import tacos_components

DIED = 9
FILE_OPERATIONS = ("open", "os.mkdir", "os.rename", "os.remove", "sqlite3.connect")
READS = ("SELECT", "PRAGMA")


class DefaultComponents:
    """The default components without the other hooks, which look at the machine and take their time."""

    tacos_components = staticmethod(tacos_components)


def study(out: Path) -> None:
    plugins = Plugins()
    plugins.register(toy_plugin)
    plugins.register(DefaultComponents(), "defaults")
    recipe = toy_recipe(
        **LEARNER,
        optimizer={"population": 3, "keep": 1, "parents": 2, "generations": 2},
        compare={"cameras": ["flea3"], "evaluations": 2},
        rig={"binning": 200},
        test={"frames": 2, "episodes": 1},
        study={"renew_training": "each_candidate", "train_best": 2},
    )
    run(recipe, plugins, out, resume=out.exists())


def in_child(work: Callable[[], None], kill_after_s: float | None = None) -> bool:
    """Do it in a forked child; whether it came to its end."""
    pid = os.fork()
    if pid == 0:
        work()
        os._exit(0)
    if kill_after_s is not None:
        time.sleep(kill_after_s)
        os.kill(pid, signal.SIGKILL)
    _, status = os.waitpid(pid, 0)
    code = os.waitstatus_to_exitcode(status)
    assert code in (0, DIED, -signal.SIGKILL), f"the child ended with {code}"
    return code == 0


def dying_at(operation: int, folder: Path, work: Callable[[], None]) -> Callable[[], None]:
    """The work, ended before its n-th file operation or statement to a database, without any cleaning up."""
    count = 0

    def see() -> None:
        nonlocal count
        if count == operation:
            os._exit(DIED)
        count += 1

    def see_statement(statement: str) -> None:
        if not statement.startswith(READS):
            see()

    def watch(event: str, arguments: tuple[Any, ...]) -> None:
        if event in FILE_OPERATIONS and str(folder) in str(arguments[0]):
            see()

    connect = sqlite3.connect

    def watched_connect(*arguments: Any, **options: Any) -> sqlite3.Connection:
        connection = connect(*arguments, **options)
        connection.set_trace_callback(see_statement)
        return connection

    def watched() -> None:
        sys.addaudithook(watch)
        sqlite3.connect = watched_connect
        work()

    return watched


def main(how: str, folder: Path, *numbers: str) -> None:
    study(folder / "first")  # here: what it imports on the way, the others need not
    began = time.monotonic()
    study(folder / "whole")
    if how == "each":
        (stride,) = map(int, numbers)
        operation, ended = 0, False
        while not ended:
            out = folder / str(operation)
            ended = in_child(dying_at(operation, out, lambda out=out: study(out)))
            if not ended:
                assert in_child(lambda out=out: study(out))
            operation += stride
    else:
        seed, kills = map(int, numbers)
        out = folder / "killed"
        rng, whole_s = random.Random(seed), time.monotonic() - began
        killed = 0
        while killed < kills:
            if not in_child(lambda: study(out), rng.uniform(0.0, 0.5) * whole_s):
                killed += 1
            elif killed:
                break
            else:  # the machine was busier a moment ago
                shutil.rmtree(out)
                whole_s /= 2
        assert in_child(lambda: study(out))


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), *sys.argv[3:])
