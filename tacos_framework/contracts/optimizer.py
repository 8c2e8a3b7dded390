"""The derivative-free side."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal, Protocol

from tacos_framework.settings import Settings
from tacos_framework.values import Candidate

ScoreScale = Literal["real", "count", "share"]
"""Kind of number of a score: any, 0 or more, or between 0 and 1."""


@dataclass(frozen=True)
class DesignProblem:
    """The problem of an optimizer beside its design space."""

    fitness: Any
    """The weighted sum of scores, `tacos_framework.fitness.Fitness`."""
    episodes: int
    """How many episodes there are to score a candidate on; where the recipe cuts episodes into blocks, each
    block counts as one."""
    coordinates: Callable[[Candidate], Mapping[str, float]]
    """What images depend on, by name, for a candidate that breaks nothing: what the rig declares, and the
    other variables. The names are the same for all candidates."""
    broken: Callable[[Candidate], Mapping[str, float]]
    """By how much a candidate breaks each constraint, in the unit of its quantity; empty where it keeps all.
    What the rig refuses breaks ``rig`` by 1. Nothing is rendered for it."""
    scales: Mapping[str, ScoreScale] = field(default_factory=dict)
    """The kind of number of each score of the fitness that says so, by ``node.score``."""
    depends_on: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """The coordinates a score depends on, for scores that say so; the others depend on all."""
    weights_learn: bool = False
    """True if tasks learn meanwhile, so that equal candidates get other scores later."""
    episodes_renew: bool = False
    """True if each round brings other episodes, so that a number names another one in the next round."""


@dataclass(frozen=True)
class Asked:
    """A candidate to evaluate, and how thoroughly."""

    candidate: Candidate
    episodes: tuple[int, ...] | None = None
    """The episodes to score it on, counted from 0, each once; None for all there are."""


@dataclass(frozen=True)
class Evaluated:
    """The result of a candidate."""

    candidate: Candidate
    """As it was asked."""
    fitness: float | None
    """Higher is better [weighted sum of scores]; None when it failed or breaks a constraint."""
    failed: str | None = None
    """Why, in a sentence."""
    episodes: Mapping[int, Mapping[str, float]] = field(default_factory=dict)
    """The scores of each episode it was scored on, by number; with several scenarios they are called
    ``scenario/node.score``. They are there as well where it failed only because none of these episodes gives
    a score that the fitness takes."""
    standard_errors: Mapping[str, float] = field(default_factory=dict)
    """Of the mean of each score over those episodes, where there are two or more."""
    broken: Mapping[str, float] = field(default_factory=dict)
    """By how much it breaks each constraint."""
    images: int = 0
    """How many images were rendered for it; none where it was known from before."""


class Optimizer(Protocol):
    """The derivative-free side: ``Class(config, space=space, rng=rng)``, then ask and tell until stop.

    Its ``__init__`` may take a further keyword ``problem`` and is then given the `DesignProblem`.
    `OptimizerBase` has the optional members.
    """

    Config: ClassVar[type[Settings]]

    @property
    def expected_candidates(self) -> int | None:
        """Number of candidates it will ask for in all, for progress bars; None when it cannot tell."""
        ...

    def ask(self) -> list[Candidate] | list[Asked]:
        """The next candidates, snapped to the space, or `Asked`; never empty before `stop` gives a reason."""
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


class OptimizerBase:
    """Optional members of an `Optimizer`, with their defaults."""

    recommend: Callable[[int], list[Candidate]] | None = None
    """``recommend(count)``: the candidates it thinks best, the best first; the study scores them once more
    on fresh episodes. Without it, those of highest mean fitness are."""
    choose: Callable[[Sequence[Evaluated]], int] | None = None
    """``choose(finalists)``: the place, among those candidates as they were `Evaluated` on fresh episodes,
    of the best one. Their numbers of episodes name other scenes than those of `tell`. Without it, that of
    highest fitness is."""
    notes: ClassVar[Callable[..., Iterable[str]] | None] = None
    """``notes(config, space)``, a class method: what whoever reads the plan should know of a search with
    these settings, in sentences, such as that it ends before anything is learnt."""
    budget: ClassVar[str | None] = None
    """The setting (a whole number) that says how long it goes on, where `restore` of a state from before
    goes on with a larger one as if it had been that large from the start: such studies can be extended."""
