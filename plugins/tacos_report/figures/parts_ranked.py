"""Every part with its fitness and what is credible of it, best first."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from matplotlib.figure import Figure

from tacos_report.analysis import RankedPart
from tacos_report.figures.canvas import NARROW_IN, draw, hover, light_grid
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

    - `products`: by name of a part, the place of its product among the cameras (its colour) and its title.
    - `designed`: names of the rows that have the designed camera's parts.
    - `narrow`: for the width of a phone.
    """
    said = ", ".join(f"{part.part} {number(part.fitness)}" for part in parts)

    def titled(part: RankedPart) -> str:
        return products[part.part][1] if part.part in products else ""

    def colour(part: RankedPart) -> str:
        if part.part in designed:
            return camera_colour(0)
        return camera_colour(products[part.part][0]) if part.part in products else DOT

    def dot(part: RankedPart) -> tuple[str, float, str, bool]:
        """Marker, size and colour, and whether it is filled: a part that was measured."""
        sold = part.part in products
        size = (9.0 if part.rescored else 6.5) + (1 if sold else 0)
        return "D" if sold else "o", size, colour(part), bool(part.episodes)

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        if (best := parts[0].ci) is not None:
            axes.axvspan(*best, color=DOT, alpha=0.13, linewidth=0, zorder=0)
        known = [(place, part.ci, colour(part)) for place, part in enumerate(parts) if part.ci is not None]
        if known:
            places, intervals, colours = zip(*known, strict=True)
            low, high = zip(*intervals, strict=True)
            axes.hlines(places, low, high, colors=colours, linewidth=2.2, alpha=0.75, capstyle="projecting")
        dots: dict[tuple[str, float, str, bool], list[int]] = {}
        for place, part in enumerate(parts):
            dots.setdefault(dot(part), []).append(place)
            if (title := titled(part)) and title != part.part:
                right = part.ci[1] if part.ci else part.fitness
                axes.annotate(title, (right, place), (7, 0), textcoords="offset points", va="center",
                              color=colour(part), fontsize=8)  # fmt: skip
        for (marker, size, own, measured), at in dots.items():  # of a kind together: each takes a while
            fill, edge, width = (own, PAPER, 0.8) if measured else (PAPER, own, 1.4)
            (line,) = axes.plot(
                [parts[place].fitness for place in at], at, marker, markersize=size, linestyle="",
                color=fill, markeredgecolor=edge, markeredgewidth=width,
            )  # fmt: skip
            hover(line, [_hovered(parts[place]) for place in at])
        axes.set_yticks(range(len(parts)), [part.part for part in parts])
        for label, part in zip(axes.get_yticklabels(), parts, strict=True):
            own = colour(part)
            weight = "bold" if part.part in designed else "normal"
            label.set(color=INK if own == DOT else own, fontsize=8.5, fontweight=weight)
        axes.set_ylim(len(parts) - 0.3, -0.7)
        axes.margins(x=0.05)
        axes.set_xlabel("fitness at its own best optics (higher is better)")
        axes.spines[["left", "bottom"]].set_visible(False)
        light_grid(axes, "x")

    name, width_in = ("parts-ranked-narrow", NARROW_IN) if narrow else ("parts-ranked", 9.2)
    size_in = (width_in, 0.7 + _ROW_IN * len(parts))
    return draw(name, size_in, f"{len(parts)} parts by fitness: {said}.", paint)


def _hovered(part: RankedPart) -> str:
    interval = f" (95 % {number(part.ci[0])} to {number(part.ci[1])})" if part.ci else ""
    seen = f"rendered in {part.episodes} scenes" if part.episodes else "predicted"
    return f"{part.part}: {number(part.fitness)}{interval}, {seen}"
