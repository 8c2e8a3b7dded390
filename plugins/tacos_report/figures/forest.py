"""Forest plot: the difference from every product with its interval."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from tacos_report import verdicts
from tacos_report.analysis import Comparison
from tacos_report.figures.canvas import NARROW_IN, draw, hover, light_grid, name_rows
from tacos_report.palette import INK, MUTED, RULE, camera_colour
from tacos_report.quantities import signed


def forest(
    comparisons: Sequence[Comparison],
    titles: Mapping[str, str],
    indices: Mapping[str, int],
    margin: float,
    narrow: bool = False,
) -> str:
    """SVG of one row per comparison that has an interval.

    - `titles`, `indices`: what people call each product, and its place among the cameras, which gives its
      colour.
    - `margin`: differences below it count as none [fitness].
    - `narrow`: for the width of a phone: names and verdicts stand above the bars.
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
            (dot,) = axes.plot([each.difference], [place], "o", color=colour, markersize=9, linestyle="")
            low, high = (signed(end) for end in each.interval)
            hover(dot, [f"{titles[each.against]}: {signed(each.difference)} (95 % {low} to {high})"])
            weight = "bold" if each.verdict in ("better", "worse") else "normal"
            word = verdicts.WORDS[each.verdict]
            if not narrow:
                axes.annotate(
                    word, (1.0, place), xycoords=("axes fraction", "data"), xytext=(8, 0),
                    textcoords="offset points", va="center", color=INK, fontsize=9.5, fontweight=weight,
                )  # fmt: skip
        names = [
            f"{titles[each.against]}: {verdicts.WORDS[each.verdict]}" if narrow else titles[each.against]
            for each in comparisons
        ]
        for label, each in zip(name_rows(axes, names, narrow=narrow), comparisons, strict=True):
            clear = narrow and each.verdict in ("better", "worse")
            label.set(color=INK, fontweight="bold" if clear else "normal")
        axes.set_ylim(len(comparisons) - 0.4, -0.6)
        axes.margins(x=0.08)
        compared = "less product" if narrow else "designed camera less product, in fitness"
        axes.set_xlabel(f"worse  ←  {compared}  →  better")
        axes.spines[["left", "bottom"]].set_visible(False)
        light_grid(axes, "x")

    name, size_in = "forest", (9.2, 0.8 + 0.42 * len(comparisons))
    if narrow:
        name, size_in = "forest-narrow", (NARROW_IN, 0.7 + 0.55 * len(comparisons))
    return draw(name, size_in, f"Designed camera against products: {said}.", paint)
