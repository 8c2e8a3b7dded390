"""The optimizer as a study calls it: what it gives is checked, and its errors name it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, NoReturn

import numpy as np

from tacos_framework.contracts import Evaluated
from tacos_framework.errors import ContractBroken
from tacos_framework.plan import ConfiguredComponent
from tacos_framework.variables.design_space import Candidate, DesignSpace


class GuardedOptimizer:
    """An optimizer of a recipe; implements `tacos_framework.contracts.Optimizer`.

    Parameters
    ----------
    part
        The component.
    space
        The variables it searches.
    rng
        Its generator.

    Raises
    ------
    ContractBroken
        From any method, where the optimizer gives what its contract rules out.
    """

    def __init__(self, part: ConfiguredComponent, space: DesignSpace, rng: np.random.Generator) -> None:
        self._part, self._space = part, space
        self._optimizer = part.make(space=space, rng=rng)

    @property
    def expected_candidates(self) -> int | None:
        """How many candidates it will ask for in all; None when it cannot tell."""
        with self._part.calling("expected_candidates"):
            expected = self._optimizer.expected_candidates
            if expected is not None and not isinstance(expected, int | np.integer):
                self._refuse(f"expected_candidates is {expected!r}", "a whole number, or None")
            return None if expected is None else int(expected)

    def ask(self) -> list[Candidate]:
        """The next candidates; none only where `stop` gives a reason."""
        with self._part.calling("ask"):
            asked = self._optimizer.ask()
            if not isinstance(asked, list | tuple):
                self._refuse(f"ask() gives {_short(asked)}", "a list of candidates")
            for number, candidate in enumerate(asked, 1):
                self._check(candidate, f"candidate {number} of {len(asked)}")
        if not asked and self.stop() is None:
            with self._part.calling("ask"):
                self._refuse("ask() gives no candidates", "at least one, as stop() gives no reason to end")
        return list(asked)

    def tell(self, evaluated: Sequence[Evaluated]) -> None:
        """Hand over the results of the candidates last asked."""
        with self._part.calling("tell"):
            self._optimizer.tell(evaluated)

    def stop(self) -> str | None:
        """Why there is nothing more to ask; None to go on."""
        with self._part.calling("stop"):
            reason = self._optimizer.stop()
            if reason is not None and not (isinstance(reason, str) and reason.strip()):
                self._refuse(f"stop() gives {_short(reason)}", "a reason in a sentence, or None to go on")
            return reason

    def state(self) -> dict[str, Any]:
        """All that is needed to go on, as JSON values."""
        with self._part.calling("state"):
            state = self._optimizer.state()
            if not isinstance(state, dict):
                self._refuse(f"state() gives {_short(state)}", "a dict of JSON values")
            try:
                json.dumps(state, allow_nan=False)
            except (TypeError, ValueError) as error:
                self._refuse(f"state() gives what JSON cannot hold: {error}", "a dict of JSON values")
            return state

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from a `state`."""
        with self._part.calling("restore"):
            self._optimizer.restore(state)

    def _check(self, candidate: Any, name: str) -> None:
        """Refuse a candidate that this space does not hold."""
        if not isinstance(candidate, Candidate):
            self._refuse(f"ask() gives {_short(candidate)} as {name}", "a Candidate, made by space.decode")
        if set(candidate.values) != set(self._space.names):
            self._refuse(
                f"ask() gives {name} with values for {_listed(candidate.values)}",
                f"values for {_listed(self._space.names)}",
            )
        try:
            nearest = self._space.decode(candidate.genes)
        except ValueError as error:
            self._refuse(f"ask() gives {name} with the genes {candidate.genes}", f"its own genes: {error}")
        if candidate != nearest:
            self._refuse(
                f"ask() gives {name}, {candidate.as_dict()}, which is outside of the design space",
                f"a candidate made by space.decode, here {nearest.as_dict()}",
            )

    def _refuse(self, given: str, expected: str) -> NoReturn:
        raise ContractBroken(f"{self._part.origin}: {given}; expected {expected}")


def _listed(names: Any) -> str:
    return ", ".join(names) or "nothing"


def _short(given: Any) -> str:
    text = repr(given)
    return text if len(text) <= 60 else f"a {type(given).__name__}"
