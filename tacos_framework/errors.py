"""Errors that speak to the user: where, what was found, what was expected, what to do."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

_NOT_PRINTABLE = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]"
)
"""Control characters but tab and line feed, marks of direction, and halves of characters."""


def printable(text: str) -> str:
    """Text with control characters written as escapes, so that a terminal shows them and obeys none.

    >>> print(printable("sensor" + chr(27) + "[2J"))
    sensor\\x1b[2J
    """
    return _NOT_PRINTABLE.sub(lambda found: found[0].encode("unicode_escape").decode("ascii"), text)


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong with what the user gave."""

    where: str
    """File, line and column (``recipe.yaml:12:3``), or the name of what is at fault."""
    what: str
    """Description of the find, with its value."""
    expected: str = ""
    """The right value, or ``""`` where `what` says it already."""
    remedy: str = ""
    """The remedy, as an imperative sentence, or ``""``."""

    def __str__(self) -> str:
        lines = [f"{self.where}: {self.what}"]
        if self.expected:
            lines.append(f"  expected: {self.expected}")
        if self.remedy:
            lines.append(f"  to do: {self.remedy}")
        return printable("\n".join(lines))


class UserError(Exception):
    """The user's input is wrong. Carries every fault found, not only the first.

    The command line prints the faults and ends with status 2, without a traceback.
    """

    def __init__(self, faults: Fault | Iterable[Fault]):
        self.faults = (faults,) if isinstance(faults, Fault) else tuple(faults)
        super().__init__("\n".join(map(str, self.faults)))

    def __reduce__(self) -> tuple[type[UserError], tuple[tuple[Fault, ...]], dict[str, Any]]:
        return type(self), (self.faults,), self.__dict__  # notes travel between processes too


class CandidateFailed(Exception):
    """A component cannot evaluate *this* candidate (too large, degenerate), but may evaluate others.

    The study tells the optimizer that the candidate failed, with this message, and goes on. Any other
    exception is a defect: of those, ``study: {on_error: ...}`` says what becomes.
    """


class ContractBroken(Exception):
    """A component does what its contract rules out; the message names it, what it gave, what was expected.

    No input of the user's is to blame, and no other component: the plugin has a defect.
    """


def did_you_mean(
    given: str, known: Iterable[str], also_called: Mapping[str, Collection[str]] = MappingProxyType({})
) -> str:
    """The remedy for an unknown name: those that may be meant, or the names that exist.

    `also_called`: what others call some of them, in lower case; see `tacos_framework.settings.also_called`.
    """
    from tacos_framework.suggestions import suggestions

    names = sorted(known)
    if suggested := [repr(name) for name in suggestions(given, names, also_called)]:
        *first, last = suggested
        return f"Did you mean {' or '.join(filter(None, (', '.join(first), last)))}?"
    return f"Known names: {', '.join(names)}." if names else ""
