"""Records of evaluations in a run's folder."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tacos_framework.cache import content_key
from tacos_framework.simulation import Evaluation


def candidate_record(evaluation: Evaluation) -> dict[str, Any]:
    """A candidate as lines of ``generations.jsonl`` and the finalists of ``result.json`` have it.

    ``episodes`` are the scores of each episode it was scored on, by its number; with several scenarios they
    are called ``scenario/node.score``.
    """
    return {
        "key": content_key(evaluation.values),
        "camera": evaluation.values,
        "derived": evaluation.derived,
        "fitness": evaluation.fitness,
        "scores": evaluation.scores,
        "terms": evaluation.terms,
        "episodes": {str(number): scores for number, scores in evaluation.scores_by_episode.items()},
        "images": evaluation.images,
        "failed": evaluation.failed,
        "broken": evaluation.broken,
        "cached": evaluation.cached,
        **({"scenarios": evaluation.scenarios} if evaluation.scenarios else {}),
    }


def generation_record(
    number: int, evaluations: Sequence[Evaluation], best: Evaluation | None, seconds: float
) -> dict[str, Any]:
    """A generation as lines of ``generations.jsonl`` have it, with the best candidate until then."""
    return {
        "generation": number,
        "seconds": round(seconds, 3),
        "frames": sum(evaluation.images for evaluation in evaluations),
        "candidates": [candidate_record(evaluation) for evaluation in evaluations],
        "best": best and {"camera": best.values, "fitness": best.fitness, "scores": best.scores},
    }
