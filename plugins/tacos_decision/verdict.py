"""Claims of a study, in keys of ``result.json``: a verdict with its certainty, or the reason for none."""

from __future__ import annotations

from typing import Any

from tacos_framework import StudyRecord
from tacos_framework.study import PairedInterval


def verdict(record: StudyRecord) -> dict[str, Any]:
    """The keys ``decision``, ``decision_absent`` where there is none, and ``comparisons``."""
    ranked = sorted(record.comparisons.items(), key=lambda each: each[1].difference)
    titles = {camera.name: camera.title for camera in record.products}
    comparisons: list[dict[str, Any]] = [_comparison(name, found) for name, found in ranked]
    comparisons += [
        {"against": name, "title": titles[name], "verdict": "not admissible", "why": why}
        for name, why in record.failed.items()
        if name in titles
    ]
    absent = record.degenerate or _absent(record)
    settings = record.recipe.test
    if settings is None or absent is not None:
        return {"decision": None, "decision_absent": absent, "comparisons": comparisons}
    best, closest = ranked[0]
    return {
        "decision": {
            **_comparison(best, closest),
            "margin": closest.margin,
            "margins": record.problem.fitness.margins,
            "confidence": settings.confidence,
            "sentence": _sentence(titles[best], closest, settings.confidence),
        },
        "comparisons": comparisons,
    }


def _comparison(name: str, found: PairedInterval) -> dict[str, Any]:
    return {
        "against": name,
        "verdict": found.verdict,
        "difference": found.difference,
        "interval": found.interval and list(found.interval),
        "episodes": found.episodes,
    }


def _absent(record: StudyRecord) -> str | None:
    """Why there is nothing to decide, in a sentence that says what to do."""
    if record.recipe.test is None:
        return (
            "The recipe has no test scenes. Add test: {seed: ..., episodes: ...} to compare on unseen scenes."
        )
    if record.recipe.compare is None:
        return "The recipe names no camera to compare the design with. Add compare: {cameras: [...]}."
    if not record.comparisons:
        return "No camera could be compared with the design on the test scenes; comparisons says why."
    return None


def _sentence(title: str, found: PairedInterval, confidence: float) -> str:
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
                f"On {scenes} the designed camera and {title} are equal within the margin of "
                f"{found.margin:.3g} ({interval})."
            )
        case _:
            return (
                f"{scenes} do not decide if the designed camera or {title} is better ({interval}): "
                "set test.most_episodes higher, so that more scenes are added."
            )
