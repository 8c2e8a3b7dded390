"""Progress messages of a study or a procedure."""

from __future__ import annotations

from typing import Protocol

from tacos_framework.simulation import Evaluation


class Progress(Protocol):
    """Listens to a study or a procedure. The command line draws a bar; library users may pass their own."""

    def phase(self, title: str, candidates: int | None) -> None:
        """A part begins, such as a search or the test; with how many candidates or steps it will take."""
        ...

    def evaluated(self, evaluation: Evaluation) -> None:
        """One candidate was evaluated, or its evaluation taken from an earlier, equal one."""
        ...

    def best(self, best: Evaluation | None) -> None:
        """A generation ended; the best of this phase so far."""
        ...

    def step(self, note: str = "") -> None:
        """One step of a procedure's phase is done; what came out, in a word or a number."""
        ...


class Silent:
    """Tells nothing."""

    def phase(self, title: str, candidates: int | None) -> None:
        """Ignore it."""

    def evaluated(self, evaluation: Evaluation) -> None:
        """Ignore it."""

    def best(self, best: Evaluation | None) -> None:
        """Ignore it."""

    def step(self, note: str = "") -> None:
        """Ignore it."""
