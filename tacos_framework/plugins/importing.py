"""Imports of strangers' modules: bounded in time, named should they end the process, their traces undone."""

from __future__ import annotations

import locale
import os
import platform
import random
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Any, TypeVar
from urllib.parse import quote, unquote
from weakref import WeakKeyDictionary

from tacos_framework.plugins.failures import tried

Result = TypeVar("Result")

LIMIT_VARIABLE = "TACOS_IMPORT_S"
"""Environment variable: the longest time an import may take [s]."""

IMPORT_S = 60.0
"""What an import may take where the variable says nothing: torch on a slow disk is far below [s]."""

WITHOUT_VARIABLE = "TACOS_WITHOUT"
"""Environment variable: distributions or entry points to leave out, ``name,name``."""

_GRACE_S = 5.0  # what a thread that was left behind may go on when all is done
_RINGS = 3  # how often an import that catches everything is told to end


class TookTooLong(BaseException):
    """An import took longer than it may. No `Exception`, lest the import catch it."""


def imported(
    load: Callable[[], Result], plugin: str, remark: Callable[[str], None]
) -> tuple[Result | None, BaseException | None]:
    """What an import gives, or what it raises; see `tried`.

    Parameters
    ----------
    load
        Imports something of the plugin.
    plugin
        The plugin, as the user knows it.
    remark
        Told, a sentence each, what the import changed in this process, and whether that was undone.
    """
    with _marked(plugin):
        return tried(partial(_watched, load, plugin, remark), f"the import of plugin {plugin}")


def _watched(load: Callable[[], Result], plugin: str, remark: Callable[[str], None]) -> Result:
    before = [(what, read, restore, read()) for what, read, restore in _ASPECTS]
    environment, path, threads = dict(os.environ), list(sys.path), set(threading.enumerate())
    try:
        with _bounded(plugin):
            return load()
    finally:
        for what, read, restore, value in before:
            if value is not None and read() != value:
                restore(value)
                remark(f"its import changed {what}, which was undone")
        if names := _undone_environment(environment):
            remark(f"its import changed the environment, which was undone: {', '.join(names)}")
        if not set(path) <= set(sys.path):
            sys.path[:] = [*path, *(folder for folder in sys.path if folder not in path)]
            remark("its import took folders out of sys.path, which was undone")
        if folders := [folder for folder in sys.path if folder not in path]:
            remark(f"its import added to sys.path: {', '.join(folders)}")
        for thread in set(threading.enumerate()) - threads:
            if not thread.daemon:
                _left_behind[thread] = plugin
                remark(f"its import left a thread running that keeps programs from ending: {thread.name}")


# what an import may change ------------------------------------------------------------------------------


def _folder() -> str | None:
    with suppress(OSError):  # it may be gone
        return os.getcwd()
    return None


def _undone_environment(before: dict[str, str]) -> list[str]:
    """Undo what changes the host: variables that were set or are ours.

    Libraries add some for themselves, and folders to those that list folders; that is left.
    """

    def grown(name: str) -> bool:
        return name.endswith("PATH") and before[name] in os.environ.get(name, "")

    changed = [name for name in before if os.environ.get(name) != before[name] and not grown(name)]
    ours = [name for name in os.environ if name.startswith("TACOS_") and name not in before]
    for name in ours:
        del os.environ[name]
    os.environ.update({name: before[name] for name in changed})
    return sorted([*changed, *ours])


def _handlers() -> dict[int, Any] | None:
    if threading.current_thread() is not threading.main_thread():
        return None
    return {number: signal.getsignal(number) for number in signal.valid_signals()}


def _set_handlers(handlers: dict[int, Any]) -> None:
    for number, handler in handlers.items():
        if handler is not None and signal.getsignal(number) != handler:
            signal.signal(number, handler)


def _numpy_errors() -> dict[str, str]:
    read = getattr(sys.modules.get("numpy"), "geterr", None)
    return read() if read else {"divide": "warn", "over": "warn", "under": "ignore", "invalid": "warn"}


def _blanket_filters() -> list[Any]:
    return [each for each in warnings.filters if each[1:4] == (None, Warning, None) and each[0] == "ignore"]


def _set_blanket_filters(kept: list[Any]) -> None:
    new = [each for each in _blanket_filters() if each not in kept]
    warnings.filters[:] = [each for each in warnings.filters if each not in new]  # type: ignore[index]


_ASPECTS: tuple[tuple[str, Callable[[], Any], Callable[[Any], object]], ...] = (
    ("the working directory", _folder, os.chdir),
    ("handlers of signals", _handlers, _set_handlers),
    ("the locale", partial(locale.setlocale, locale.LC_ALL), partial(locale.setlocale, locale.LC_ALL)),
    ("the state of random", random.getstate, random.setstate),
    ("how numpy takes errors", _numpy_errors, lambda kept: sys.modules["numpy"].seterr(**kept)),
    ("the filters of warnings, to hide all", _blanket_filters, _set_blanket_filters),
)


# imports that do not end --------------------------------------------------------------------------------


@contextmanager
def _bounded(plugin: str) -> Iterator[None]:
    """Raise `TookTooLong` in a body that takes too long: in the main thread, where timers are heard of.

    A host whose own timer is running keeps it, and no bound.
    """
    is_main = threading.current_thread() is threading.main_thread()
    if not is_main or not hasattr(signal, "setitimer") or signal.getitimer(signal.ITIMER_REAL)[0]:
        yield
        return
    try:
        limit_s = max(float(os.environ.get(LIMIT_VARIABLE, IMPORT_S)), 1e-3)
    except ValueError:
        limit_s = IMPORT_S
    rings = 0

    def ring(number: int, frame: FrameType | None) -> None:
        nonlocal rings
        rings += 1
        if rings > _RINGS:
            _say(
                f"the import of plugin {plugin} cannot be stopped; leave it out: {WITHOUT_VARIABLE}={plugin}"
            )
            os._exit(1)
        raise TookTooLong(f"more than {limit_s:g} s, which {LIMIT_VARIABLE} changes")

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, limit_s, 1.0)
    try:
        yield
    except TookTooLong:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        _say(f"plugin {plugin} is not imported in {limit_s:g} s; spare the wait: {WITHOUT_VARIABLE}={plugin}")
        raise
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


# imports that end the process ---------------------------------------------------------------------------


def _marks() -> Path | None:
    """Where a file stands for each import that is under way: its name says who imports what."""
    given = os.environ.get("TACOS_CACHE", "")
    if given == "off":
        return None
    home = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return Path(given or Path(home) / "tacos") / "importing"


@contextmanager
def _marked(plugin: str) -> Iterator[None]:
    """Leave a mark should the process end meanwhile, as by a crash or `os._exit`."""
    folder = _marks()
    mark = folder and folder / "@".join((quote(platform.node()), str(os.getpid()), quote(plugin, safe="")))
    if folder and mark:
        with suppress(OSError):  # a disk that is full or not ours
            folder.mkdir(parents=True, exist_ok=True)
            mark.touch()
    try:
        yield
    finally:
        if mark:
            with suppress(OSError):
                mark.unlink()


def say_what_ended_the_last_start() -> None:
    """Name each plugin whose import a process of this machine did not survive, once."""
    marks = _marks()
    for mark in sorted(marks.glob(f"{quote(platform.node())}@*@*")) if marks else ():
        _, process, plugin = mark.name.split("@")
        if process.isdecimal() and not _is_running(int(process)):
            with suppress(OSError):
                mark.unlink()
            name = unquote(plugin)
            _say(
                f"an earlier start ended while plugin {name} was imported. Should this one, too, leave it "
                f"out: {WITHOUT_VARIABLE}={name}"
            )


def _is_running(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:  # it is another user's
        pass
    return True


# threads that keep a program from ending ----------------------------------------------------------------

_left_behind: WeakKeyDictionary[threading.Thread, str] = WeakKeyDictionary()


def end_without_left_threads(status: int) -> None:
    """Once the main thread has ended, wait a little for threads that imports left, and end the process.

    Parameters
    ----------
    status
        The exit status of the process.
    """
    if any(thread.is_alive() for thread in _left_behind):
        threading.Thread(target=_end, args=(status,), daemon=True).start()


def _end(status: int) -> None:
    threading.main_thread().join()
    until = time.monotonic() + _GRACE_S
    while left := {plugin for thread, plugin in list(_left_behind.items()) if thread.is_alive()}:
        if time.monotonic() > until:
            _say(f"ended without waiting for threads that were left by plugin {' and '.join(sorted(left))}")
            sys.stdout.flush()
            os._exit(status)
        time.sleep(0.05)


def _say(warning: str) -> None:
    print(f"warning: {warning}", file=sys.stderr, flush=True)
