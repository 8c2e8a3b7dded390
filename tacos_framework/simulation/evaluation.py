"""Outcome of a candidate's evaluation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from traceback import format_exception
from typing import Any

from tacos_framework.contracts import Scores, State
from tacos_framework.errors import CandidateFailed, ContractBroken
from tacos_framework.fitness import Fitness, mean_scores, weighted_mean
from tacos_framework.plugins import culprit_of


@dataclass(frozen=True)
class Raised:
    """The error that ended an evaluation, as text, so that it can travel between processes."""

    component: str
    """The component it arose in, with its distribution; empty where that is not known."""
    kind: str
    traceback: str


@dataclass(frozen=True)
class Evaluation:
    """Outcome of one candidate."""

    values: Mapping[str, Any]
    """Plain values of all variables that were set."""
    derived: Mapping[str, float] = field(default_factory=dict)
    scores: Scores = field(default_factory=dict)
    """``{"node.score": value}``, means over the episodes; empty when it failed."""
    fitness: float | None = None
    """Weighted sum; None when it failed."""
    terms: Mapping[str, float] = field(default_factory=dict)
    failed: str | None = None
    """Why there is no fitness, in a sentence."""
    episodes: tuple[Mapping[str, float], ...] = ()
    """Scores and fitness of each episode by itself, so that cameras can be compared episode by episode. They
    stay where it failed only because none of them gives a score that the fitness takes.
    """
    images: int = 0
    seconds: Mapping[str, float] = field(default_factory=dict)
    """Time spent in each node [s]."""
    states: Mapping[str, State] = field(default_factory=dict)
    """States of the trainable tasks after training on this candidate."""
    cached: bool = False
    """Taken from an earlier, equal evaluation."""
    raised: Raised | None = None
    """The error behind `failed`, where a component has a defect rather than nothing to say."""
    scenario_episodes: Mapping[str, Sequence[Scores]] = field(default_factory=dict)
    """The scores of each episode in each scenario, where there are several."""
    scenarios: Mapping[str, Scores] = field(default_factory=dict)
    """Then also the scores and the fitness of each scenario by itself."""
    broken: Mapping[str, float] = field(default_factory=dict)
    """By how much it breaks each constraint, as `DesignProblem.broken` has it; nothing was rendered then."""
    episode_numbers: tuple[int, ...] = ()
    """Numbers of the episodes in the study, counted from 0; empty where they are not counted."""

    @property
    def scores_by_episode(self) -> dict[int, dict[str, float]]:
        """Scores of the tasks in each episode, by its number; named as in `blocks`, without fitness."""
        return {
            number: {name: value for name, value in scores.items() if name.rpartition("/")[2] != "fitness"}
            for number, scores in zip(self.episode_numbers, self.blocks, strict=False)  # none are counted
        }

    @property
    def blocks(self) -> tuple[Scores, ...]:
        """The scores of each episode; with several scenarios those of all, called ``scenario/node.score``."""
        if not self.scenario_episodes:
            return tuple(self.episodes)
        columns = self.scenario_episodes.items()
        return tuple(
            {f"{name}/{score}": value for name, episodes in columns for score, value in episodes[i].items()}
            for i in range(len(next(iter(self.scenario_episodes.values()))))
        )


def failed_by(evaluation: Evaluation, error: BaseException) -> Evaluation:
    """An evaluation that an error ended: what it says, and which component of which distribution it is of."""
    culprit = culprit_of(error)
    kind = type(error).__name__
    reason = f"{kind}: {error}" if str(error) else kind
    if isinstance(error, ContractBroken):  # it names the component itself
        reason = str(error)
    elif culprit is not None:
        place = f" ({culprit.doing})" if culprit.doing else ""
        reason = f"{culprit.name} raised {reason}{place}"
    raised = Raised(culprit.name if culprit else "", kind, "".join(format_exception(error)))
    return replace(evaluation, failed=reason, raised=raised)


def with_fitness(evaluation: Evaluation, fitness: Fitness) -> Evaluation:
    """An evaluation with scores, fitness and terms from the scores of its episodes.

    Raises `CandidateFailed` when no episode reports a score that the fitness takes.
    """
    if evaluation.scenario_episodes:
        return _with_fitness_in_scenarios(evaluation, fitness)
    scores = mean_scores(evaluation.episodes)
    return replace(
        evaluation,
        scores=scores,
        fitness=fitness.value(scores),
        terms=fitness.contributions(scores),
        episodes=tuple(_episode_with_fitness(episode, fitness) for episode in evaluation.episodes),
    )


def with_fitness_or_failed(evaluation: Evaluation, fitness: Fitness) -> Evaluation:
    """As `with_fitness`; it has failed where its episodes do not give every score the fitness takes."""
    try:
        return with_fitness(evaluation, fitness)
    except CandidateFailed as error:
        return replace(evaluation, failed=str(error))


def _with_fitness_in_scenarios(evaluation: Evaluation, fitness: Fitness) -> Evaluation:
    """Scores are weighted means over the scenarios; fitness and terms too, or they are those of the worst."""
    columns = {
        name: tuple(_episode_with_fitness(episode, fitness) for episode in episodes)
        for name, episodes in evaluation.scenario_episodes.items()
    }
    means = {name: mean_scores(episodes) for name, episodes in evaluation.scenario_episodes.items()}
    counts = fitness.weights(means)
    scenarios = {name: {**scores, "fitness": fitness.value(scores)} for name, scores in means.items()}
    episodes = []
    for i in range(len(next(iter(columns.values())))):
        row = {name: column[i] for name, column in columns.items()}
        episode = weighted_mean(row, fitness.mean_weights)
        episode.pop("fitness", None)
        if all("fitness" in row[name] for name, weight in counts.items() if weight > 0):
            episode["fitness"] = weighted_mean(row, counts)["fitness"]
        episodes.append(episode)
    terms = weighted_mean({name: fitness.contributions(scores) for name, scores in means.items()}, counts)
    return replace(
        evaluation,
        scores=weighted_mean(means, fitness.mean_weights),
        fitness=weighted_mean(scenarios, counts)["fitness"],
        terms=terms,
        episodes=tuple(episodes),
        scenario_episodes=columns,
        scenarios=scenarios,
    )


def _episode_with_fitness(scores: Scores, fitness: Fitness) -> dict[str, float]:
    """An episode's scores, and its fitness where it has every score that takes."""
    if any(term.score not in scores for term in fitness.terms):
        return dict(scores)
    return {**scores, "fitness": fitness.value(scores)}


def merged_evaluation(partials: Sequence[Evaluation], fitness: Fitness) -> Evaluation:
    """One evaluation of what separate jobs did for a candidate, in their order.

    `partials`: training, or scores of some episodes, with the fitness left open. One that failed fails the
    whole, as do episodes that together do not give every score the fitness takes.
    """
    seconds: dict[str, float] = {}
    for partial in partials:
        for node, spent in partial.seconds.items():
            seconds[node] = seconds.get(node, 0.0) + spent
    images = sum(partial.images for partial in partials)
    failed = next((partial for partial in partials if partial.failed), None)
    if failed is not None:
        return replace(failed, images=images, seconds=seconds)
    episodes = tuple(episode for partial in partials for episode in partial.episodes)
    columns = {
        name: tuple(episode for partial in partials for episode in partial.scenario_episodes.get(name, ()))
        for name in dict.fromkeys(name for partial in partials for name in partial.scenario_episodes)
    }
    whole = replace(partials[0], episodes=episodes, scenario_episodes=columns, images=images, seconds=seconds)
    return with_fitness_or_failed(whole, fitness)
