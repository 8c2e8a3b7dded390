"""The optimizer as a study calls it: what it gives is checked, and its errors name it."""

from __future__ import annotations

import inspect
import json
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NoReturn

import numpy as np

from tacos_framework.contracts import Asked, DesignProblem, Evaluated, OptimizerBase, optional
from tacos_framework.errors import ContractBroken
from tacos_framework.fitness import standard_errors
from tacos_framework.plan import ConfiguredComponent
from tacos_framework.simulation import Evaluation
from tacos_framework.variables.design_space import Candidate, DesignSpace


class GuardedOptimizer:
    """An optimizer of a recipe, called as `tacos_framework.contracts.Optimizer` says.

    Raises `ContractBroken` from any method, where the optimizer gives what its contract rules out.

    - `problem`: what it is told of the problem, if it asks for it.
    """

    def __init__(
        self, part: ConfiguredComponent, space: DesignSpace, rng: np.random.Generator, problem: DesignProblem
    ) -> None:
        self._part, self._space, self._episodes = part, space, problem.episodes
        supplied: dict[str, Any] = {"space": space, "rng": rng}
        if takes_problem(part.cls):
            supplied["problem"] = problem
        self._optimizer = part.make(None, **supplied)

    @property
    def origin(self) -> str:
        """The optimizer with its distribution, as messages have it."""
        return self._part.origin

    @property
    def expected_candidates(self) -> int | None:
        """Number of candidates it will ask for in all; None if it cannot tell."""
        with self._part.calling("expected_candidates"):
            expected = self._optimizer.expected_candidates
            if expected is not None and not isinstance(expected, int | np.integer):
                self._refuse(f"expected_candidates is {expected!r}", "a whole number, or None")
            return None if expected is None else int(expected)

    def ask(self) -> list[Asked]:
        """The next candidates, each with its episodes in rising order; none only where `stop` says why."""
        with self._part.calling("ask"):
            given = self._optimizer.ask()
            if not isinstance(given, list | tuple):
                self._refuse(f"ask() gives {_short(given)}", "a list of candidates")
            asked = []
            for number, each in enumerate(given, 1):
                name = f"candidate {number} of {len(given)}"
                wanted = each if isinstance(each, Asked) else Asked(each)
                self._check(wanted.candidate, "ask()", name)
                asked.append(self._with_checked_episodes(wanted, name))
        if not asked and self.stop() is None:
            with self._part.calling("ask"):
                self._refuse("ask() gives no candidates", "at least one, as stop() gives no reason to end")
        return asked

    def tell(self, evaluated: Sequence[Evaluated]) -> None:
        """Hand over the results of the candidates last asked."""
        with self._part.calling("tell"):
            self._optimizer.tell(evaluated)

    @property
    def recommends(self) -> bool:
        """True if it takes part in the choice of the best candidates."""
        return callable(optional(self._optimizer, OptimizerBase, "recommend"))

    def recommend(self, count: int) -> list[Candidate] | None:
        """The candidates it thinks best, at most `count`, each once; None where it has no say in that."""
        if not self.recommends:
            return None
        with self._part.calling("recommend"):
            given = self._optimizer.recommend(count)
            if not isinstance(given, list | tuple):
                self._refuse(f"recommend() gives {_short(given)}", "a list of candidates")
            if len(given) > count:
                self._refuse(f"recommend({count}) gives {len(given)} candidates", f"at most {count}")
            for number, candidate in enumerate(given, 1):
                name = f"candidate {number} of {len(given)}"
                self._check(candidate, "recommend()", name)
            return list(dict.fromkeys(given))

    def choose(self, finalists: Sequence[Evaluated]) -> int | None:
        """The place of the finalist it thinks best; None where it has no say in that."""
        if not callable(optional(self._optimizer, OptimizerBase, "choose")):
            return None
        with self._part.calling("choose"):
            place = self._optimizer.choose(finalists)
            if not _is_one_of(place, len(finalists)):
                self._refuse(
                    f"choose() gives {_short(place)} for {len(finalists)} finalists",
                    f"the place of one, from 0 to {len(finalists) - 1}",
                )
            return int(place)

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
        with self._part.calling("restore"):
            self._optimizer.restore(state)

    def _check(self, candidate: Any, call: str, name: str) -> None:
        """Refuse a candidate that this space does not hold."""
        given = f"{call} gives {name}"
        if not isinstance(candidate, Candidate):
            self._refuse(f"{call} gives {_short(candidate)} as {name}", "a Candidate, made by space.decode")
        if set(candidate.values) != set(self._space.names):
            self._refuse(
                f"{given} with values for {_listed(candidate.values)}",
                f"values for {_listed(self._space.names)}",
            )
        try:
            nearest = self._space.decode(candidate.genes)
        except ValueError as error:
            self._refuse(f"{given} with the genes {candidate.genes}", f"its own genes: {error}")
        if candidate != nearest:
            self._refuse(
                f"{given}, {candidate.as_dict()}, which is outside of the design space",
                f"a candidate made by space.decode, here {nearest.as_dict()}",
            )

    def _with_checked_episodes(self, asked: Asked, name: str) -> Asked:
        """The request, its episodes as plain numbers in rising order."""
        given = asked.episodes
        if given is None:
            return asked
        count = self._episodes
        known = isinstance(given, list | tuple) and all(_is_one_of(each, count) for each in given)
        if not known or not given or len(set(given)) < len(given):
            self._refuse(
                f"ask() gives {name} with the episodes {_short(given)}",
                f"one or more of the numbers 0 to {count - 1}, each once, or None for all",
            )
        return replace(asked, episodes=tuple(sorted(int(number) for number in given)))

    def _refuse(self, given: str, expected: str) -> NoReturn:
        raise ContractBroken(f"{self._part.origin}: {given}; expected {expected}")


def result_of(asked: Asked, evaluation: Evaluation) -> Evaluated:
    """The result of a candidate, for the optimizer."""
    episodes = evaluation.scores_by_episode
    return Evaluated(
        asked.candidate,
        evaluation.fitness,
        failed=evaluation.failed,
        episodes=episodes,
        standard_errors=standard_errors(list(episodes.values())),
        broken=evaluation.broken,
        images=evaluation.images,
    )


def not_evaluated(asked: Asked, reason: str) -> Evaluated:
    """The result of a candidate that is not evaluated any more, for the optimizer."""
    return Evaluated(asked.candidate, None, failed=f"not evaluated: {reason}")


def takes_problem(optimizer: type[Any]) -> bool:
    """True if a class of optimizers takes the `DesignProblem` by a keyword of its ``__init__``."""
    try:
        return "problem" in inspect.signature(optimizer.__init__).parameters
    except (TypeError, ValueError):  # what is written in C may not tell
        return False


def _is_one_of(number: Any, count: int) -> bool:
    whole = isinstance(number, int | np.integer) and not isinstance(number, bool)
    return whole and 0 <= number < count


def _listed(names: Any) -> str:
    return ", ".join(names) or "nothing"


def _short(given: Any) -> str:
    text = repr(given)
    return text if len(text) <= 60 else f"a {type(given).__name__}"
