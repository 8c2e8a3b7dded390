"""Reasons of plugins that cannot be used: kept and shown, and no obstacle to others."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeVar

Result = TypeVar("Result")

WITHOUT_VARIABLE = "TACOS_WITHOUT"
"""Environment variable: distributions or entry points to leave out, ``name,name``."""


@dataclass(frozen=True)
class PluginFailure:
    """A plugin, or something it offers, that cannot be used."""

    plugin: str
    """Name of the distribution, entry point or module."""
    reason: str
    error: BaseException | None = None
    """The exception it raised, unchanged; None when the framework refused it."""
    uses: tuple[str, ...] = ()
    """The components that are lost by it, as far as they are known."""
    remedy: str = "Update or uninstall it."


class PluginFailures:
    """Plugins that cannot be used, each reason once."""

    def __init__(self) -> None:
        self._kept: dict[tuple[str, str], PluginFailure] = {}

    def __iter__(self) -> Iterator[PluginFailure]:
        return iter(self._kept.values())

    def add(
        self,
        plugin: str,
        reason: str,
        error: BaseException | None = None,
        uses: tuple[str, ...] = (),
        remedy: str = "Update or uninstall it.",
    ) -> None:
        """Keep a failure; see `PluginFailure`."""
        self._kept[plugin, reason] = PluginFailure(plugin, reason, error, uses, remedy)


def tried(
    call: Callable[[], Result], doing: str = "what a plugin does"
) -> tuple[Result | None, BaseException | None]:
    """Return value of a plugin's code, or the error it raises, `SystemExit` included.

    `KeyboardInterrupt` alone passes, with a note of what it interrupted.
    """
    process, result, raised = os.getpid(), None, None
    try:
        result = call()
    except KeyboardInterrupt as interrupt:
        interrupt.add_note(f"during {doing}")
        raise
    except BaseException as error:  # noqa: BLE001 - also those that would end the host without a word
        raised = error
    finally:
        end_copy_of(process, doing)
    return result, raised


def end_copy_of(process: int, doing: str) -> None:
    """End this process where it is no longer `process`: a fork that came back would be a second host."""
    if os.getpid() != process:
        os.write(2, f"warning: {doing} forked this process; the copy was ended\n".encode())
        os._exit(1)


def in_words(error: BaseException) -> str:
    """The type of an error and what it says."""
    text = str(error)
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
