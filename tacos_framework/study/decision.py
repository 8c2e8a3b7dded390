"""What a study claims, in keys of ``result.json``: a verdict with its certainty, or why there is none."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tacos_framework.recipe import Recipe
from tacos_framework.study.search import Search
from tacos_framework.study.sequential import PairedInterval
from tacos_framework.study.unseen_test import UnseenTest


def decision(
    recipe: Recipe,
    test: UnseenTest | None,
    titles: Mapping[str, str],
    left_out: Mapping[str, str],
    why_none: str | None,
) -> dict[str, Any]:
    """The keys ``decision``, ``decision_absent`` and ``comparisons``.

    Parameters
    ----------
    recipe
        Its section ``test:`` says how sure is sure enough.
    test
        What came out on the test scenes; None where the recipe has none.
    titles
        What people call each camera.
    left_out
        Products without a score, and why in a sentence.
    why_none
        Why no winner may be named, whatever the scores are; None where one may.
    """
    settings, found = recipe.test, test.comparisons if test else {}
    ranked = sorted(found.items(), key=lambda each: each[1].difference)
    failed = {name: each.failed for name, each in test.evaluations.items() if each.failed} if test else {}
    comparisons: list[dict[str, Any]] = [_comparison(name, each) for name, each in ranked]
    comparisons += [
        {"against": name, "verdict": "not admissible", "why": why}
        for name, why in {**left_out, **failed}.items()
        if name in titles
    ]
    absent = why_none or _absent(recipe, found)
    if settings is None or test is None or absent is not None:
        return {"decision": None, "decision_absent": absent, "comparisons": comparisons}
    best, closest = ranked[0]
    fitness = test.evaluations[test.designed].fitness or 0.0
    margin = settings.margin * abs(fitness)
    return {
        "decision": {
            **_comparison(best, closest),
            "margin": margin,
            "margin_share": settings.margin,
            "confidence": settings.confidence,
            "sentence": _sentence(titles.get(best, best), closest, settings.confidence, margin),
        },
        "comparisons": comparisons,
    }


def degenerate(designed: Search, recipe: Recipe) -> str | None:
    """Why this study may name no winner, in a sentence that says what to do; None where it may.

    Parameters
    ----------
    designed
        The search of the designed camera.
    recipe
        What was run.
    """
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


def _comparison(name: str, found: PairedInterval) -> dict[str, Any]:
    return {
        "against": name,
        "verdict": found.verdict,
        "difference": found.difference,
        "interval": found.interval and list(found.interval),
        "episodes": found.episodes,
    }


def _absent(recipe: Recipe, found: Mapping[str, PairedInterval]) -> str | None:
    """Why there is nothing to decide, in a sentence that says what to do."""
    if recipe.test is None:
        return (
            "The recipe has no test scenes. Add test: {seed: ..., episodes: ...} to compare on unseen scenes."
        )
    if recipe.compare is None:
        return "The recipe names no camera to compare the design with. Add compare: {cameras: [...]}."
    if not found:
        return "No camera could be compared with the design on the test scenes; comparisons says why."
    return None


def _sentence(title: str, found: PairedInterval, confidence: float, margin: float) -> str:
    scenes = f"{found.episodes} unseen scene{'s' if found.episodes != 1 else ''}"
    if found.interval is None:
        return (
            f"{scenes} are too few to compare the designed camera with {title}: "
            "set test.most_episodes higher, so that scenes are added until it is decided."
        )
    low, high = found.interval
    interval = f"{confidence:.0%} interval {low:+.3g} to {high:+.3g}".replace("%", " %")
    match found.verdict:
        case "better" | "worse":
            return (
                f"On {scenes} the designed camera is {found.verdict} than {title}, by "
                f"{abs(found.difference):.3g} ({interval})."
            )
        case "equivalent":
            return (
                f"On {scenes} the designed camera and {title} are equal within the margin of {margin:.3g} "
                f"({interval})."
            )
        case _:
            return (
                f"{scenes} do not tell whether the designed camera or {title} is better ({interval}): "
                "set test.most_episodes higher, so that more scenes are added."
            )
