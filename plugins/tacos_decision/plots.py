"""Figures of a study's result with matplotlib: each takes a result and gives the axes it drew on."""

from __future__ import annotations

from itertools import accumulate
from typing import TYPE_CHECKING

from tacos_framework import Fault, UserError
from tacos_report.palette import MUTED, camera_colour

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from tacos_decision.tables import StudyResult


def ranking(result: StudyResult, *, first: int = 20, axes: Axes | None = None) -> Axes:
    """The best parts from the top, with 95 % intervals; filled dots were rendered, hollow ones predicted."""
    rows = result.rows("ranking")[:first]
    if not rows:
        raise _missing("a ranking", str(result.data.get("ranking_absent", "tacos_decision writes it")))
    axes = _own(axes)
    for place, row in enumerate(rows):
        filled = "full" if row["episodes"] else "none"
        axes.plot([row["low"], row["high"]], [place, place], color=MUTED, linewidth=1)
        axes.plot(row["fitness"], place, marker="o", color=camera_colour(0), fillstyle=filled)
    axes.set_yticks(range(len(rows)), [row["part"] for row in rows])
    axes.invert_yaxis()
    axes.set_xlabel("fitness (95 % interval)")
    return axes


def progress(result: StudyResult, *, axes: Axes | None = None) -> Axes:
    """Fitness of each candidate of the search for the design, and the best so far, over images rendered."""
    rows = [row for row in result.rows("candidates") if row["product"] is None]
    spent = accumulate(row["images"] for row in rows)
    scored = [(images, row["fitness"]) for images, row in zip(spent, rows, strict=True)]
    scored = [(images, fitness) for images, fitness in scored if fitness is not None]
    if not scored:
        raise _missing("a scored candidate", "generations.jsonl lies beside result.json")
    axes = _own(axes)
    images, fitness = zip(*scored, strict=True)
    axes.plot(images, fitness, "o", color=MUTED, markersize=3, label="candidates")
    axes.step(images, [*accumulate(fitness, max)], where="post", color=camera_colour(0), label="best so far")
    axes.set_xlabel("images rendered")
    axes.set_ylabel("fitness")
    axes.legend()
    return axes


def scores_by_scene(result: StudyResult, score: str = "fitness", *, axes: Axes | None = None) -> Axes:
    """A score of each camera on each test scene, scene 0 first; a line for each camera."""
    cameras = result.data.get("cameras", {})
    known = sorted({name for each in cameras.values() for scene in each["episodes"] for name in scene})
    if score not in known:
        raise _missing(f"{score!r} of test scenes", f"one of {', '.join(known) or 'none: run a test'}")
    axes = _own(axes)
    for index, camera in enumerate(cameras.values()):
        drawn = [(place, scene[score]) for place, scene in enumerate(camera["episodes"]) if score in scene]
        axes.plot(*zip(*drawn, strict=True), "o-", color=camera_colour(index), label=camera["title"])
    axes.set_xlabel("test scene")
    axes.set_ylabel(score)
    axes.legend()
    return axes


def _own(axes: Axes | None) -> Axes:
    """The axes that were given, or those of a new figure of pyplot."""
    if axes is not None:
        return axes
    from matplotlib import pyplot

    return pyplot.subplots(layout="constrained")[1]


def _missing(what: str, expected: str) -> UserError:
    return UserError(Fault("the result", f"it has no {what.removeprefix('a ')}", expected))
