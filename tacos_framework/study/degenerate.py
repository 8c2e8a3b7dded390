"""Can the scores of a study tell cameras apart at all?"""

from __future__ import annotations

from tacos_framework.recipe import Recipe
from tacos_framework.study.search import Search


def degenerate(designed: Search, recipe: Recipe) -> str | None:
    """Why this study may name no winner, in a sentence that says what to do; None where it may."""
    if designed.best is None:
        reason = designed.last_failure or designed.stopped or "nothing was evaluated"
        remedy = "Widen design: or loosen constraints:" if designed.broken_in_a_row else "log.txt says more"
        return f"No camera could be scored, so none is named: {reason}. {remedy}."
    found = {stats.mean_fitness for stats in designed.candidate_stats.values()}
    if len(designed.candidate_stats) > 1 and len(found) == 1:
        scored = f"All {len(designed.candidate_stats)} cameras of the search"
        if found == {0.0}:
            return (
                f"{scored} score zero: the tasks see nothing in these scenes, so no camera is named. "
                "Give more light, more pixels or easier tasks."
            )
        return (
            f"{scored} have the same fitness, {found.pop():.4g}, so no camera is named: the scores do not "
            "tell cameras apart. Choose harder scenes, or scores that are graded."
        )
    test = recipe.test
    scenes = test.most_episodes or test.episodes if test else recipe.study.episodes * recipe.study.blocks
    if scenes == 1:
        key = "test.episodes" if test else "study.episodes"
        return (
            "All cameras were judged on a single scene, which cannot tell luck from merit, so no winner is "
            f"named: set {key} to 6 or more."
        )
    return None
