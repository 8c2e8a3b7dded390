"""The search: every candidate as a dot, the best so far as a line, over the images rendered."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import accumulate
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from tacos_report.figures.canvas import NARROW_IN, draw, hover, light_grid
from tacos_report.palette import DOT, INK, MUTED, PAPER, camera_colour
from tacos_report.quantities import number, shown, words
from tacos_report.study_data import Generation, Tried


def search_curve(
    generations: Sequence[Generation],
    is_design: Callable[[Mapping[str, Any]], bool] = lambda _: False,
    *,
    narrow: bool = False,
) -> str:
    """SVG of fitness against images rendered (or candidates, where no images were counted).

    `is_design`: true if the variables are the designed camera's, which gets the star where it was first
    tried: the highest dot may be luck.
    """
    spent = [generation.frames for generation in generations]
    unit = "images rendered"
    if not sum(spent):  # every capture came from the cache, or the renderer counts none
        spent, unit = [len(generation.tried) for generation in generations], "candidates evaluated"
    ends = list(accumulate(spent))
    placed = _placed(generations, ends)
    scored = [(x, candidate.fitness) for x, candidate in placed if candidate.fitness is not None]
    cameras = [_hovered(candidate) for _, candidate in placed if candidate.fitness is not None]
    designed = [
        (x, tried.fitness) for x, tried in placed if tried.fitness is not None and is_design(tried.camera)
    ][:1]  # optimizers that keep their best try it again and again
    failed = [x for x, candidate in placed if candidate.fitness is None]
    description = (
        f"Search curve: {len(scored)} scored and {len(failed)} failed candidates over {ends[-1]} {unit}."
    )

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        if scored:
            xs, ys = zip(*scored, strict=True)
            (dots,) = axes.plot(
                xs, ys, "o", color=DOT, alpha=0.55, markersize=5, linestyle="", label="candidate"
            )
            hover(dots, cameras)
            best = list(accumulate(ys, max))
            line: dict[str, Any] = {"color": INK, "linewidth": 1.8, "drawstyle": "steps-post"}
            axes.plot([*xs, ends[-1]], [*best, best[-1]], label="best so far", **line)
        if designed:
            star: dict[str, Any] = {"color": camera_colour(0), "markersize": 15, "zorder": 5, "linestyle": ""}
            axes.plot(*zip(*designed, strict=True), "*", label="designed", markeredgecolor=PAPER, **star)
            axes.annotate(
                number(designed[0][1]), designed[0], (0, 10), textcoords="offset points", ha="center",
                color=camera_colour(0), fontsize=10.5, fontweight="bold",
            )  # fmt: skip
        axes.margins(x=0.02, y=0.14)
        if failed:
            foot = axes.get_xaxis_transform()
            axes.plot(failed, [0.025] * len(failed), "x", color=INK, markersize=5, markeredgecolor=INK,
                      transform=foot, linestyle="", label="failed, no fitness")  # fmt: skip
        axes.set_xlim(0, ends[-1] * 1.02 or 1)
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: number(value, 6)))
        axes.set_xlabel(unit)
        axes.set_ylabel("fitness on the scenes designed on")
        axes.spines["left"].set_visible(False)
        light_grid(axes, "y")
        _generation_axis(axes, ends, most=6 if narrow else 12)
        axes.legend(loc="lower right", ncols=2 if narrow else 4, labelcolor=MUTED, bbox_to_anchor=(1, 0.03))

    if narrow:
        return draw("search-curve-narrow", (NARROW_IN, 3.4), description, paint)
    return draw("search-curve", (9.2, 4.0), description, paint)


def _hovered(candidate: Tried) -> str:
    camera = ", ".join(
        f"{words(name).lower()} {shown(name, value)}" for name, value in candidate.camera.items()
    )
    return f"{number(candidate.fitness or 0.0)}: {camera}"


def _placed(generations: Sequence[Generation], ends: Sequence[int]) -> list[tuple[float, Tried]]:
    """Each candidate at the images rendered once it was done, spread evenly over its generation."""
    placed = []
    for start, end, generation in zip([0, *ends], ends, generations, strict=False):
        count = len(generation.tried)
        for place, candidate in enumerate(generation.tried, start=1):
            placed.append((start + (end - start) * place / count, candidate))
    return placed


def _generation_axis(axes: Axes, ends: Sequence[int], most: int) -> None:
    every = max(1, -(-len(ends) // most))
    upper = axes.secondary_xaxis("top")
    upper.set_xticks(ends[every - 1 :: every], [str(place) for place in range(every, len(ends) + 1, every)])
    upper.set_xlabel("end of generation")
    upper.tick_params(length=0)
    upper.spines["top"].set_visible(False)
    axes.xaxis.set_major_locator(MaxNLocator(min(8, most), integer=True))
