"""What plugins that cannot be used leave behind: a reason, kept and shown, that stops nobody."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

Result = TypeVar("Result")


@dataclass(frozen=True)
class PluginFailure:
    """A plugin, or something it offers, that cannot be used.

    Parameters
    ----------
    plugin
        Name of the distribution, entry point or module.
    reason
        What went wrong, in a sentence.
    error
        The exception it raised, unchanged; None when the framework refused it.
    uses
        The components that are lost by it, as far as they are known.
    remedy
        What to do about it.
    """

    plugin: str
    reason: str
    error: BaseException | None = None
    uses: tuple[str, ...] = ()
    remedy: str = "Update or uninstall it."


def tried(call: Callable[[], Result]) -> tuple[Result | None, BaseException | None]:
    """What a stranger's code returns, or what it raises; Ctrl-C alone gets through."""
    try:
        return call(), None
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # noqa: BLE001 - also those that would end the host without a word
        return None, error


def in_words(error: BaseException) -> str:
    """The type of an error and what it says."""
    text = str(error)
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
