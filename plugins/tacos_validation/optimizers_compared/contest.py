"""One optimizer on one problem with one seed, and what it had found after how many images."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from tacos_framework.contracts import Evaluated
from tacos_framework.variables.design_space import Candidate
from tacos_validation.optimizers_compared.ledger import Ledger

MOST_ASKED_PER_EVALUATION = 20
"""A run that asks for more candidates than this for each evaluation of its budget finds nothing new."""


@dataclass(frozen=True)
class Moment:
    """Where a run stood once a candidate was evaluated.

    Parameters
    ----------
    round
        Rounds of ask and tell, this one included.
    asked
        Candidates asked so far, repeated and failed ones included.
    images
        Images rendered so far; a candidate the run had before costs none.
    seconds
        Time spent so far in evaluations and in the optimizer [s].
    best
        Best fitness so far.
    """

    round: int
    asked: int
    images: int
    seconds: float
    best: float


@dataclass
class Run:
    """A run in progress; `ask`, look the candidates up, `tell`, until it is `over`.

    Parameters
    ----------
    optimizer_name, scheme, seed
        What runs.
    optimizer
        The optimizer.
    images
        Budget [images].
    images_per_evaluation
        What one candidate costs [images].
    """

    optimizer_name: str
    scheme: str
    seed: int
    optimizer: Any
    images: int
    images_per_evaluation: int
    moments: list[Moment] = field(default_factory=list)
    winner: Mapping[str, Any] | None = None
    stopped: str = ""
    thought_seconds: float = 0.0
    _asked: list[Candidate] = field(default_factory=list)
    _known: set[str] = field(default_factory=set)
    _spent: int = 0
    _seconds: float = 0.0
    _rounds: int = 0
    _count: int = 0

    @property
    def over(self) -> bool:
        """Whether the budget is spent or the optimizer has stopped."""
        return bool(self.stopped)

    def ask(self) -> list[dict[str, Any]]:
        """The values of the next candidates."""
        began = time.perf_counter()
        self._asked = self.optimizer.ask()
        self._think(began)
        return [candidate.as_dict() for candidate in self._asked]

    def tell(self, ledger: Ledger) -> None:
        """Take in the candidates last asked."""
        self._rounds += 1
        observed = []
        for candidate in self._asked:
            values = candidate.as_dict()
            entry = ledger[values]
            observed.append(Evaluated(candidate, entry.fitness))
            self._count += 1
            if candidate.key not in self._known:
                self._known.add(candidate.key)
                self._spent += entry.images
                self._seconds += entry.seconds
            if entry.fitness is not None and self._spent <= self.images:
                self._note(values, entry.fitness)
        began = time.perf_counter()
        self.optimizer.tell(observed)
        self._think(began)
        self.stopped = self._stop()

    def _note(self, values: Mapping[str, Any], fitness: float) -> None:
        best = self.moments[-1].best if self.moments else float("-inf")
        if fitness > best:
            best, self.winner = fitness, values
        self.moments.append(Moment(self._rounds, self._count, self._spent, self._seconds, best))

    def _think(self, began: float) -> None:
        took = time.perf_counter() - began
        self._seconds += took
        self.thought_seconds += took

    def _stop(self) -> str:
        if self._spent >= self.images:
            return "budget spent"
        if self._count > MOST_ASKED_PER_EVALUATION * self.images / self.images_per_evaluation:
            return "asked again and again for what it had, or what fails"
        return self.optimizer.stop() or ""
