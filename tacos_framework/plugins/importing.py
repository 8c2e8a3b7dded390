"""Imports of strangers' modules: bounded in time, named should they end the process, their traces undone."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TypeVar
from urllib.parse import quote, unquote

from tacos_framework.plugins.failures import WITHOUT_VARIABLE, say, tried
from tacos_framework.plugins.import_time import bounded, processor_limit_s
from tacos_framework.plugins.import_traces import undone

Result = TypeVar("Result")


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

    Raises
    ------
    UserError
        When the limit of its time is set to what is none.
    """
    limit_s = processor_limit_s()

    def watched() -> Result:
        with undone(plugin, remark), bounded(plugin, limit_s):
            return load()

    with _marked(plugin):
        return tried(watched, f"the import of plugin {plugin}")


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
            say(
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
