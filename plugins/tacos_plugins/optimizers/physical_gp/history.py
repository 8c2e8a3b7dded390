"""Observations, as they are kept and as the model takes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from tacos_framework import DesignProblem, Evaluated, Fitness, FitnessTerm
from tacos_plugins.surrogate.grey_box import Observation

FITNESS = "fitness"
"""The one score there is where results come without scores of episodes."""

TIME = "time"
"""The coordinate that is the number of the round, where tasks learn meanwhile."""


@dataclass(frozen=True)
class Trial:
    genes: tuple[float, ...]
    round: int
    """When, counted from 0."""
    fitness: float | None
    episodes: Mapping[str, Mapping[str, float]]
    """Its scores in each episode, by number as text, as JSON has it."""
    failed: bool
    """True if there is nothing to learn from it but that it failed."""

    @classmethod
    def of(cls, result: Evaluated, round_number: int, scenes: str = "") -> Trial:
        """From what an optimizer is told.

        `scenes`: goes before the numbers of episodes that name other scenes than those of the search.
        """
        episodes = {
            f"{scenes}{number}": {name: float(value) for name, value in scores.items()}
            for number, scores in result.episodes.items()
        }
        failed = result.fitness is None and not any(episodes.values())
        return cls(tuple(result.candidate.genes), round_number, result.fitness, episodes, failed)

    def as_json(self) -> dict[str, Any]:
        return {**asdict(self), "genes": list(self.genes)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Trial:
        """Undoes :meth:`as_json`."""
        return cls(**{**data, "genes": tuple(data["genes"])})


def scored_episodes(
    trials: Sequence[Trial], problem: DesignProblem | None
) -> dict[tuple[float, ...], set[int] | None]:
    """For each candidate, by its genes, the episodes that would tell nothing new of it; None if it failed.

    Where episodes are renewed, or tasks have learnt since, any would.
    """
    changes = problem is not None and (problem.episodes_renew or problem.weights_learn)
    done: dict[tuple[float, ...], set[int] | None] = {}
    for trial in trials:
        before = done.get(trial.genes, set())
        scored = set() if changes else {int(number) for number in trial.episodes}
        done[trial.genes] = None if trial.failed or before is None else before | scored
    return done


def scores_known(trials: Sequence[Trial]) -> bool:
    """True if results come with scores of episodes, all that succeeded."""
    return all(trial.episodes or trial.failed for trial in trials)


def observations(
    trial: Trial, coordinates: Mapping[str, float], problem: DesignProblem | None, by_score: bool
) -> list[Observation]:
    """Observations of a trial for the model, at its coordinates.

    `problem`: whether episodes are renewed and weights learn. `by_score`: whether to take the scores of its
    episodes, or its fitness alone.
    """
    if trial.failed:
        return []
    if problem is not None and problem.weights_learn:
        coordinates = {**coordinates, TIME: float(trial.round)}
    if not by_score:
        return [] if trial.fitness is None else [Observation(coordinates, None, {FITNESS: trial.fitness})]
    era = trial.round if problem is not None and problem.episodes_renew else 0
    return [Observation(coordinates, f"{era}/{number}", scores) for number, scores in trial.episodes.items()]


def fitness_alone() -> Fitness:
    """The fitness where it is all that is known."""
    return Fitness((FitnessTerm(FITNESS, 1.0),))
