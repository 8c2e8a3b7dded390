"""All that follows from what a study scored, as keys of ``result.json``."""

from __future__ import annotations

from typing import Any

from tacos_decision.equivalence import equivalence
from tacos_decision.fronts import front
from tacos_decision.importance import importance
from tacos_decision.model import CameraModel
from tacos_decision.optimum import best_of_parts
from tacos_decision.pool import Pool
from tacos_decision.ranking import left_out, ranking
from tacos_framework import StudyRecord, UserError, in_one_thread


@in_one_thread
def analyse(record: StudyRecord) -> dict[str, Any]:
    """Rank every part, find the equals, the tolerances, what matters, and the front.

    Returns: ``ranking``, ``ranking_left_out``, ``equivalent``, ``importance``, and ``front`` where the recipe
    has objectives. Nothing where the study itself names no winner; ``ranking_absent`` says why where the
    model of the scores allows no conclusion.
    """
    if record.degenerate is not None:
        return {}
    model = CameraModel.fit(record)
    if model.box.degenerate is not None:
        return {"ranking_absent": f"No camera can be ranked: {model.box.degenerate}."}
    pool = Pool(record.space)
    aims, model = _front(model, pool)  # first, as all that follows learns from what is scored for it
    found = best_of_parts(model, pool)
    if not found.cameras:
        return {"ranking_absent": "No camera can be ranked: none of those tried keeps all constraints."}
    return {
        "ranking": ranking(model, pool, found, record.problem.fitness.margin),
        "ranking_left_out": left_out(model, pool, found),
        "equivalent": equivalence(model, pool, found, record.problem.fitness),
        "importance": importance(model, pool, found.best),
        **aims,
    }


def _front(model: CameraModel, pool: Pool) -> tuple[dict[str, Any], CameraModel]:
    try:
        aims, model = front(model, pool)
    except UserError as error:  # the rest of the analysis does not need pymoo
        return {"front_absent": str(error)}, model
    return {"front": aims} if aims else {}, model
