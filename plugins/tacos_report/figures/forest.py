"""Forest plot: the difference from every product with its interval."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from tacos_report import verdicts
from tacos_report.analysis import Comparison
from tacos_report.figures.canvas import draw, light_grid
from tacos_report.palette import INK, MUTED, RULE, camera_colour
from tacos_report.quantities import signed


def forest(
    comparisons: Sequence[Comparison], titles: Mapping[str, str], indices: Mapping[str, int], margin: float
) -> str:
    """SVG of one row per comparison that has an interval.

    Parameters
    ----------
    titles, indices
        What people call each product, and its place among the cameras, which gives its colour.
    margin
        Differences below it count as none [fitness].
    """
    said = "; ".join(
        f"{titles[each.against]} {signed(each.difference or 0.0)}, {verdicts.WORDS[each.verdict]}"
        for each in comparisons
    )

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        if margin > 0:
            axes.axvspan(-margin, margin, color=RULE, alpha=0.45, linewidth=0, zorder=0)
        axes.axvline(0, color=MUTED, linewidth=1)
        for place, each in enumerate(comparisons):
            assert each.interval is not None
            assert each.difference is not None
            colour = camera_colour(indices[each.against]) if each.against in indices else INK
            axes.plot(each.interval, [place, place], color=colour, linewidth=3, solid_capstyle="butt")
            axes.plot([each.difference], [place], "o", color=colour, markersize=9, linestyle="")
            axes.annotate(
                verdicts.WORDS[each.verdict], (1.0, place), xycoords=("axes fraction", "data"),
                xytext=(8, 0), textcoords="offset points", va="center", color=INK, fontsize=9.5,
                fontweight="bold" if each.verdict in ("better", "worse") else "normal",
            )  # fmt: skip
        axes.set_yticks(range(len(comparisons)), [titles[each.against] for each in comparisons])
        axes.tick_params(axis="y", labelcolor=INK)
        axes.set_ylim(len(comparisons) - 0.4, -0.6)
        axes.margins(x=0.08)
        axes.set_xlabel("worse  ←  designed camera less product, in fitness  →  better")
        axes.spines[["left", "bottom"]].set_visible(False)
        light_grid(axes, "x")

    return draw(
        "forest", (9.2, 0.8 + 0.42 * len(comparisons)), f"Designed camera against products: {said}.", paint
    )
