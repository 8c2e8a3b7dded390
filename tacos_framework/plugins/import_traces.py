"""What an import leaves behind in this process: undone where it can be, and said."""

from __future__ import annotations

import locale
import os
import random
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any
from weakref import WeakKeyDictionary

from tacos_framework.plugins.failures import say

_GRACE_S = 5.0  # what a thread that was left behind may go on when all is done


@contextmanager
def undone(plugin: str, remark: Callable[[str], None]) -> Iterator[None]:
    """Undo what an import in the body changes; parameters are those of `imported`."""
    before = [(what, read, restore, read()) for what, read, restore in _ASPECTS]
    environment, path, threads = dict(os.environ), list(sys.path), set(threading.enumerate())
    try:
        yield
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


# threads that keep a program from ending ------------------------------------------------------------------

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
            say(f"ended without waiting for threads that were left by plugin {' and '.join(sorted(left))}")
            sys.stdout.flush()
            os._exit(status)
        time.sleep(0.05)
