"""Every part with its fitness and what is credible of it, best first."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from matplotlib.figure import Figure

from tacos_report.analysis import RankedPart
from tacos_report.figures.canvas import NARROW_IN, draw, light_grid
from tacos_report.palette import DOT, INK, PAPER, camera_colour
from tacos_report.quantities import number

_ROW_IN = 0.215


def parts_ranked(
    parts: Sequence[RankedPart],
    products: Mapping[str, tuple[int, str]],
    designed: Collection[str],
    narrow: bool = False,
) -> str:
    """SVG of one row per part: dot, 95 % interval, and the product that has it; a band is the interval of
    the first.

    Parameters
    ----------
    products
        By name of a part, the place of its product among the cameras (its colour) and its title.
    designed
        Names of the rows that have the designed camera's parts.
    narrow
        For the width of a phone.
    """
    said = ", ".join(f"{part.part} {number(part.fitness)}" for part in parts)

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        if (best := parts[0].ci) is not None:
            axes.axvspan(*best, color=DOT, alpha=0.13, linewidth=0, zorder=0)
        for place, part in enumerate(parts):
            index, title = products.get(part.part, (None, ""))
            colour = (
                camera_colour(0) if part.part in designed else DOT if index is None else camera_colour(index)
            )
            if part.ci is not None:
                axes.plot(part.ci, [place, place], color=colour, linewidth=2.2, alpha=0.75, zorder=1)
            size = (9.0 if part.rescored else 6.5) + (1 if index is not None else 0)
            axes.plot(
                [part.fitness], [place], "D" if index is not None else "o", markersize=size, linestyle="",
                color=colour if part.episodes else PAPER, markeredgecolor=PAPER if part.episodes else colour,
                markeredgewidth=0.8 if part.episodes else 1.4, zorder=2,
            )  # fmt: skip
            if title and title != part.part:
                right = part.ci[1] if part.ci else part.fitness
                axes.annotate(title, (right, place), (7, 0), textcoords="offset points", va="center",
                              color=colour, fontsize=8)  # fmt: skip
        axes.set_yticks(range(len(parts)), [part.part for part in parts])
        for label, part in zip(axes.get_yticklabels(), parts, strict=True):
            if part.part in designed:
                label.set(color=camera_colour(0), fontsize=8.5, fontweight="bold")
            else:
                index = products.get(part.part, (None, ""))[0]
                label.set(color=INK if index is None else camera_colour(index), fontsize=8.5)
        axes.set_ylim(len(parts) - 0.3, -0.7)
        axes.margins(x=0.05)
        axes.set_xlabel("fitness at its own best optics (higher is better)")
        axes.spines[["left", "bottom"]].set_visible(False)
        light_grid(axes, "x")

    name, width_in = ("parts-ranked-narrow", NARROW_IN) if narrow else ("parts-ranked", 9.2)
    size_in = (width_in, 0.7 + _ROW_IN * len(parts))
    return draw(name, size_in, f"{len(parts)} parts by fitness: {said}.", paint)
