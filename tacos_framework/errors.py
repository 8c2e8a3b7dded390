"""Errors that speak to the user: where, what was found, what was expected, what to do."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong with what the user gave.

    Parameters
    ----------
    where
        File, line and column (``recipe.yaml:12:3``), or the name of what is at fault.
    what
        What was found there, with its value.
    expected
        What would have been right, or ``""`` where `what` says it already.
    remedy
        What to do about it, as an imperative sentence, or ``""``.
    """

    where: str
    what: str
    expected: str = ""
    remedy: str = ""

    def __str__(self) -> str:
        lines = [f"{self.where}: {self.what}"]
        if self.expected:
            lines.append(f"  expected: {self.expected}")
        if self.remedy:
            lines.append(f"  to do: {self.remedy}")
        return "\n".join(lines)


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


def did_you_mean(given: str, known: Iterable[str]) -> str:
    """The remedy for an unknown name: the one alike in letters or in meaning, or the names that exist."""
    from difflib import get_close_matches

    from tacos_framework.synonyms import meant

    names = sorted(known)
    alike = get_close_matches(given, names, n=1)
    nearly_equal = get_close_matches(given, names, n=1, cutoff=0.8)
    begun = [name for name in names if len(given) > 2 and name.startswith(given)]
    suggestions = (*nearly_equal, meant(given, names), *alike, *(begun if len(begun) == 1 else ()))
    if suggested := next(filter(None, suggestions), None):
        return f"Did you mean {suggested!r}?"
    return f"Known names: {', '.join(names)}." if names else ""
