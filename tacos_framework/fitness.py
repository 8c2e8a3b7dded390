"""From the scores of tasks to one number per candidate."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from tacos_framework.contracts import Scores
from tacos_framework.errors import CandidateFailed


@dataclass(frozen=True)
class FitnessTerm:
    """One term of the fitness."""

    score: str
    """``node.score``, as in ``features.inliers``."""
    weight: float
    """Its weight; negative for a score to keep small."""
    margin: float = 0.0
    """Difference of the score that does not matter, in its unit, 0 or more."""

    def __post_init__(self) -> None:
        if not math.isfinite(self.weight):
            raise ValueError(f"the weight of {self.score} must be a finite number, not {self.weight}")
        if not (math.isfinite(self.margin) and self.margin >= 0):
            raise ValueError(f"the margin of {self.score} must be 0 or more, not {self.margin}")


@dataclass(frozen=True)
class Fitness:
    """Weighted sum of scores, maximised (paper, Sec. 4.3, "Fitness Function").

    >>> fitness = Fitness((FitnessTerm("features.inliers", 0.0025), FitnessTerm("obstacle.seen_ratio", 1.0)))
    >>> fitness.value({"features.inliers": 200.0, "obstacle.seen_ratio": 0.75})
    1.25
    """

    terms: tuple[FitnessTerm, ...]
    scenarios: tuple[tuple[str, float], ...] = ()
    """Name and weight of each scenario, where there are several."""
    over: Literal["mean", "worst"] = "mean"
    """The weighted mean of the scenarios, or the worst of them."""

    def __post_init__(self) -> None:
        names = [term.score for term in self.terms]
        if not names:
            raise ValueError("a fitness needs at least one term")
        if repeated := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"the fitness names {', '.join(repeated)} more than once")

    def value(self, scores: Scores) -> float:
        """The fitness of these scores.

        Raises `CandidateFailed` when a score is missing. Raises `ValueError` when a score is not a finite
        number.
        """
        return math.fsum(self.contributions(scores).values())

    def contributions(self, scores: Scores) -> dict[str, float]:
        """Contribution of each score to the fitness; raises as :meth:`value` does."""
        missing = [term.score for term in self.terms if term.score not in scores]
        if missing:
            raise CandidateFailed(
                f"no episode gave a value for {', '.join(missing)}, which the fitness needs; "
                f"scores that were reported: {', '.join(sorted(scores)) or 'none'}"
            )
        return {term.score: term.weight * _finite(term.score, scores[term.score]) for term in self.terms}

    def weights(self, by_scenario: Mapping[str, Scores]) -> dict[str, float]:
        """Weight of each scenario in the fitness: weights that sum to 1, or 1 for the worst scenario.

        `by_scenario`: scores of each scenario, all that the fitness takes among them.

        Raises `CandidateFailed` when a score is missing in a scenario.
        """
        values = {}
        for name, scores in by_scenario.items():
            try:
                values[name] = self.value(scores)
            except CandidateFailed as error:
                raise CandidateFailed(f"in scenario {name!r}: {error}") from error
        if self.over == "worst":
            worst = min(values, key=lambda name: values[name])
            return {name: float(name == worst) for name in values}
        return self.mean_weights

    @property
    def margin(self) -> float:
        """Difference of the fitness that does not matter: the root of the sum of (weight x margin) squared.

        It is what differences of the scores come to that are each as large as its margin and independent.
        The sum would let a score differ by several of its margins, the smallest term would let the least
        important score decide. Neither the zero nor the size of the fitness enters.
        """
        return math.hypot(*(term.weight * term.margin for term in self.terms))

    @property
    def margins(self) -> dict[str, float]:
        """The margin of each score, in its unit; none where it is 0."""
        return {term.score: term.margin for term in self.terms if term.margin}

    @property
    def mean_weights(self) -> dict[str, float]:
        """The weights of the scenarios in a mean over them; their sum is 1."""
        total = math.fsum(weight for _, weight in self.scenarios)
        return {name: weight / total for name, weight in self.scenarios}


def mean_scores(episodes: Iterable[Scores]) -> dict[str, float]:
    """For each score its mean over the episodes that report it.

    An episode leaves a score out where it has no meaning (no obstacle on the path); it does not count then.

    Raises `ValueError` when a score is not a finite number: tasks leave out what they cannot tell.
    """
    columns: dict[str, list[float]] = {}
    for scores in episodes:
        for name, value in scores.items():
            columns.setdefault(name, []).append(_finite(name, value))
    return {name: math.fsum(values) / len(values) for name, values in columns.items()}


def weighted_mean(by_scenario: Mapping[str, Scores], weights: Mapping[str, float]) -> dict[str, float]:
    """For each score its weighted mean over the scenarios that report it and count."""
    names = dict.fromkeys(name for scenario in weights for name in by_scenario[scenario])
    means = {}
    for name in names:
        reported = {s: by_scenario[s][name] for s in weights if name in by_scenario[s] and weights[s] > 0}
        if reported:
            total = math.fsum(weights[s] for s in reported)
            means[name] = math.fsum(weights[s] * value for s, value in reported.items()) / total
    return means


def _finite(name: str, value: float) -> float:
    if not math.isfinite(value):
        raise ValueError(f"score {name} is {value}; a task leaves a score out where it has none")
    return float(value)


def standard_errors(episodes: Sequence[Scores]) -> dict[str, float]:
    """Standard error of the mean of each score that every one of at least two episodes reports."""
    if len(episodes) < 2:
        return {}
    everywhere = [name for name in episodes[0] if all(name in scores for scores in episodes)]
    columns = {name: [float(scores[name]) for scores in episodes] for name in everywhere}
    return {name: statistics.stdev(values) / math.sqrt(len(values)) for name, values in columns.items()}
