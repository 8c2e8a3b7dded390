"""Draws with matplotlib's objects onto inline SVG that is equal, byte for byte, for equal input."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from html import escape
from io import StringIO
from typing import Any, Literal
from urllib.parse import quote, unquote

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from tacos_report.palette import INK, MUTED, PAPER, RULE, tinted

_STYLE: dict[str, Any] = {
    "svg.fonttype": "none",  # real text: searchable, and in the page's own font
    "text.parse_math": False,  # names may hold dollar signs
    "font.family": "DejaVu Sans",  # comes with matplotlib, so the layout is the same everywhere
    "font.size": 9.0,
    "text.color": INK,
    "axes.facecolor": "none",
    "axes.edgecolor": RULE,
    "axes.labelcolor": MUTED,
    "axes.labelsize": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.titlecolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "xtick.color": RULE,
    "ytick.color": RULE,
    "xtick.labelcolor": MUTED,
    "ytick.labelcolor": MUTED,
    "grid.color": RULE,
    "grid.linewidth": 0.6,
    "figure.facecolor": "none",
    "legend.frameon": False,
    "lines.markeredgecolor": PAPER,
}
NARROW_IN = 4.3
"""Width of a drawing that a phone shows without scrolling; letters keep their size there [in]."""

_SVG_DPI = 72
"""Points of an SVG per inch, as its writer has them."""

# Everything the writer would put into an RDF block: a report names no addresses and no dates.
_NO_METADATA: dict[str, Any] = dict.fromkeys(("Creator", "Date", "Format", "Type"))


def draw(name: str, size_in: tuple[float, float], description: str, paint: Callable[[Figure], None]) -> str:
    """An inline SVG of what `paint` puts on a figure.

    - `name`: unique among the drawings of a page; keeps the ids inside them apart.
    - `size_in`: width and height [in]; it scales with the page.
    - `description`: said in place of the picture to readers who do not see it.
    - `paint`: draws in the light colours of `tacos_report.palette`.
    """
    style: Any = {**_STYLE, "svg.hashsalt": name}
    with matplotlib.rc_context(style):
        figure = Figure(figsize=size_in, dpi=_SVG_DPI, layout="constrained")
        canvas = FigureCanvasSVG(figure)
        paint(figure)
        text = StringIO()
        canvas.print_svg(text, metadata=_NO_METADATA)  # `savefig` would lay the figure out twice
    return _inline(text.getvalue(), description)


_HOVER = "hover:"
_MARKERS = re.compile(rf'<g id="{_HOVER}([^"]*)">(.*?</defs>.*?)</g>', re.DOTALL)


def hover(markers: Line2D, texts: Sequence[str]) -> None:
    """Show a text for each marker of a line while the pointer rests on it, by an SVG title."""
    markers.set_gid(_HOVER + quote(json.dumps(texts)))


def light_grid(axes: Axes, axis: Literal["x", "y"]) -> None:
    """Faint lines along one axis, no tick marks."""
    axes.grid(axis=axis)
    axes.tick_params(length=0)


def name_rows(axes: Axes, names: Sequence[str], *, narrow: bool) -> list[Text]:
    """Names of the rows 0, 1, ...: left of the axes; above each row on a phone, where they take no width."""
    if not narrow:
        axes.set_yticks(range(len(names)), names)
        return list(axes.get_yticklabels())
    axes.set_yticks([])
    return [
        axes.annotate(
            name, (0.0, place), (0, 8), xycoords=("axes fraction", "data"), textcoords="offset points",
            color=INK, va="bottom", in_layout=False,  # or a long name would leave the axes no width
        )
        for place, name in enumerate(names)
    ]  # fmt: skip


def logarithmic_height(axes: Axes) -> None:
    """A logarithmic y axis with plain numbers; matplotlib's own are in a markup that is switched off here."""
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_locator(NullLocator())


def _titled(found: re.Match[str]) -> str:
    """The group of a line with a title in each of its markers."""
    texts = iter(json.loads(unquote(found[1])))
    return re.sub(
        r"(<use [^>]*)/>",
        lambda use: f"{use[1]}><title>{escape(next(texts))}</title></use>",
        f"<g>{found[2]}</g>",
    )


def _inline(document: str, description: str) -> str:
    """The <svg> element alone, tinted and labelled, without ids that nothing refers to."""
    svg = _MARKERS.sub(_titled, document[document.index("<svg") :])
    svg = re.sub(r"<g id=\"[^\"]*\"", "<g", svg)
    svg = re.sub(r"<!--.*?-->\n?", "", svg, flags=re.DOTALL)
    svg = re.sub(r" font: ([\d.]+px)[^;\"]*", r" font-size: \1", svg.replace('style="font:', 'style=" font:'))
    svg = re.sub(r" (?:width|height)=\"[\d.]+pt\"", "", svg, count=2)
    svg = re.sub(r" (?:xmlns(?::xlink)?|version)=\"[^\"]*\"", "", svg).replace("xlink:href", "href")
    label = escape(description, quote=True)
    return tinted(svg.replace("<svg", f'<svg role="img" aria-label="{label}"', 1)).strip()
