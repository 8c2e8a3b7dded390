"""Optimizers that learn nothing: so many candidates, drawn batch by batch."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from tacos_framework import Candidate, Evaluated


class Draws(ABC):
    """Asks for so many candidates whatever they score; how each is drawn is the subclass' business.

    - `evaluations`: candidates drawn in all.
    - `batch`: candidates asked at a time; the last batch may be smaller.
    """

    def __init__(self, *, evaluations: int, batch: int) -> None:
        self._evaluations = evaluations
        self._batch = batch
        self._begin()

    def _begin(self) -> None:
        self._evaluated = 0
        self._asked = self._next()

    def _next(self) -> list[Candidate]:
        return self._draw(min(self._batch, self._evaluations - self._evaluated))

    @abstractmethod
    def _draw(self, count: int) -> list[Candidate]:
        """The next `count` candidates; count may be 0."""

    @property
    def expected_candidates(self) -> int:
        return self._evaluations

    def ask(self) -> list[Candidate]:
        return list(self._asked)

    def tell(self, evaluated: Sequence[Evaluated]) -> None:
        """Count the batch; what it scored changes nothing."""
        self._evaluated += len(evaluated)
        self._asked = self._next()

    def stop(self) -> str | None:
        """A reason once all evaluations are observed."""
        if self._evaluated < self._evaluations:
            return None
        return f"all {self._evaluations} candidates were evaluated"
