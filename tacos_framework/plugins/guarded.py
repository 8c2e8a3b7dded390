"""The one call site of whatever plugins bring: an error that leaves a component says where it comes from."""

from __future__ import annotations

import os
from dataclasses import dataclass
from types import TracebackType
from typing import TypeVar

from tacos_framework.plugins.failures import end_copy_of

Error = TypeVar("Error", bound=BaseException)

_CULPRIT = "tacos_culprit"


@dataclass(frozen=True)
class Culprit:
    """The component that was at work when an error arose."""

    use: str
    """The component, ``kind.name``."""
    distribution: str | None = None
    """The distribution it comes from; None where it was registered by hand."""
    doing: str = ""
    """Purpose of the call, e.g. ``"capture"``."""

    @property
    def name(self) -> str:
        return f"{self.use} of {self.distribution}" if self.distribution else self.use

    def __str__(self) -> str:
        return f"{self.name}, {self.doing}" if self.doing else self.name


class calling:
    """Whatever leaves the block carries a note with the component and its distribution, and is not wrapped.

    Of nested blocks the innermost is to blame, and alone adds its note.

    - `use`: the component, ``kind.name``, or the plugin whose hook is called.
    - `distribution`: the distribution it comes from, see `Plugins.distribution_of`; None where that is not
      known.
    - `doing`: what it is called for: the verb or hook, and what else tells the place.

    >>> try:
    ...     with calling("sensor.acme", "acme-cameras", "expose in node 'frames'"):
    ...         1 / 0
    ... except ZeroDivisionError as error:
    ...     print(error.__notes__[0])
    in sensor.acme of acme-cameras, expose in node 'frames'
    """

    __slots__ = ("_culprit", "_process")

    def __init__(self, use: str, distribution: str | None = None, doing: str = "") -> None:
        self._culprit = Culprit(use, distribution, doing)

    def __enter__(self) -> None:
        """Next to nothing is set up: the block costs next to nothing while all goes well."""
        self._process = os.getpid()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        end_copy_of(self._process, str(self._culprit))
        if isinstance(error, Exception | SystemExit):
            blame(error, self._culprit)


def blame(error: BaseException, culprit: Culprit) -> None:
    """Note on an error where it comes from, unless it says so already."""
    if _CULPRIT not in error.__dict__:
        error.add_note(f"in {culprit}")
        error.__dict__[_CULPRIT] = culprit


def blameless(error: Error) -> Error:
    """An error that is no component's, wherever it passes: what is wrong is in the recipe."""
    error.__dict__[_CULPRIT] = None
    return error


def culprit_of(error: BaseException) -> Culprit | None:
    """The component an error arose in; None where it was none, or is not known."""
    return getattr(error, _CULPRIT, None)
