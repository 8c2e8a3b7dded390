"""The derivative-free side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

from tacos_framework.settings import Settings


@dataclass(frozen=True)
class Evaluated:
    """A candidate and its fitness, higher is better; None when it failed or breaks a constraint."""

    candidate: Any  # tacos_framework.variables.design_space.Candidate
    fitness: float | None


class Optimizer(Protocol):
    """The derivative-free side: ``Class(config, space=space, rng=rng)``, then ask and tell until stop."""

    Config: ClassVar[type[Settings]]

    @property
    def expected_candidates(self) -> int | None:
        """How many candidates it will ask for in all, for progress bars; None when it cannot tell."""
        ...

    def ask(self) -> list[Any]:
        """The next candidates, snapped to the space; never empty before `stop` gives a reason."""
        ...

    def tell(self, evaluated: Sequence[Evaluated]) -> None:
        """The results of exactly the candidates last asked, in their order."""
        ...

    def stop(self) -> str | None:
        """Why there is nothing more to ask, in a sentence; None to go on."""
        ...

    def state(self) -> dict[str, Any]:
        """All that is needed to go on, as JSON values, generator included."""
        ...

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from a `state`; equal to never having stopped."""
        ...
