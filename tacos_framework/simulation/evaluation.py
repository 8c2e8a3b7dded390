"""What came out for a candidate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from traceback import format_exception
from typing import Any

from tacos_framework.contracts import Scores, State
from tacos_framework.errors import CandidateFailed, ContractBroken
from tacos_framework.fitness import Fitness, mean_scores
from tacos_framework.plugins import culprit_of


@dataclass(frozen=True)
class Raised:
    """The error that ended an evaluation, as text, so that it can travel between processes.

    Parameters
    ----------
    component
        The component it arose in, with its distribution; empty where that is not known.
    kind
        Type of the error.
    traceback
        Where it arose.
    """

    component: str
    kind: str
    traceback: str


@dataclass(frozen=True)
class Evaluation:
    """What came out for one candidate.

    Parameters
    ----------
    values
        Plain values of all variables that were set.
    derived
        The rig's derived quantities.
    scores
        ``{"node.score": value}``, means over the episodes; empty when it failed.
    fitness
        Weighted sum; None when it failed.
    terms
        What each score contributes to the fitness.
    failed
        Why there are no scores, in a sentence.
    episodes
        Scores and fitness of each episode by itself, so that cameras can be compared episode by episode.
    images
        Images rendered.
    seconds
        Time spent in each node [s].
    states
        States of the trainable tasks after training on this candidate.
    cached
        Taken from an earlier, equal evaluation.
    dropped
        Why it was not scored on all episodes, in a sentence; its fitness is then what its place in the race
        stands for, not the sum of `terms`, which are of the episodes it saw.
    raised
        The error behind `failed`, where a component has a defect rather than nothing to say.
    """

    values: Mapping[str, Any]
    derived: Mapping[str, float] = field(default_factory=dict)
    scores: Scores = field(default_factory=dict)
    fitness: float | None = None
    terms: Mapping[str, float] = field(default_factory=dict)
    failed: str | None = None
    episodes: tuple[Mapping[str, float], ...] = ()
    images: int = 0
    seconds: Mapping[str, float] = field(default_factory=dict)
    states: Mapping[str, State] = field(default_factory=dict)
    cached: bool = False
    dropped: str | None = None
    raised: Raised | None = None


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


def judged(evaluation: Evaluation, fitness: Fitness) -> Evaluation:
    """An evaluation with scores, fitness and terms from the scores of its episodes.

    Raises
    ------
    CandidateFailed
        When no episode reports a score that the fitness takes.
    """
    scores = mean_scores(evaluation.episodes)
    return replace(
        evaluation,
        scores=scores,
        fitness=fitness.value(scores),
        terms=fitness.terms(scores),
        episodes=tuple(_with_fitness(episode, fitness) for episode in evaluation.episodes),
    )


def _with_fitness(scores: Scores, fitness: Fitness) -> dict[str, float]:
    """An episode's scores, and its fitness where it has every score that takes."""
    if any(term.score not in scores for term in fitness.terms_of):
        return dict(scores)
    return {**scores, "fitness": fitness.value(scores)}


def joined(parts: Sequence[Evaluation], fitness: Fitness) -> Evaluation:
    """One evaluation of what was done for a candidate in parts, in their order.

    Parameters
    ----------
    parts
        Training, or scores of some episodes, with the fitness left open. A part that failed fails the whole,
        as do episodes that together do not give every score the fitness takes.
    fitness
        The weighted sum of scores.
    """
    seconds: dict[str, float] = {}
    for part in parts:
        for node, spent in part.seconds.items():
            seconds[node] = seconds.get(node, 0.0) + spent
    images = sum(part.images for part in parts)
    failed = next((part for part in parts if part.failed), None)
    if failed is not None:
        return replace(failed, images=images, seconds=seconds)
    episodes = tuple(episode for part in parts for episode in part.episodes)
    whole = replace(parts[0], episodes=episodes, images=images, seconds=seconds)
    try:
        return judged(whole, fitness)
    except CandidateFailed as error:
        return replace(whole, failed=str(error), episodes=())
