"""Texts that figures show while the pointer rests on a marker."""

from __future__ import annotations

import re

import pytest

from tacos_report.analysis import RankedPart
from tacos_report.figures.canvas import draw, hover
from tacos_report.figures.parts_ranked import parts_ranked


def titles(svg: str) -> list[tuple[float, str]]:
    """Each marker that has a title: its height in the drawing, and the title."""
    found = re.findall(r'<use [^>]*y="([\d.]+)"[^>]*><title>([^<]*)</title></use>', svg)
    return [(float(height), text) for height, text in found]


def test_each_marker_has_its_own_text_escaped() -> None:
    def paint(figure) -> None:
        axes = figure.add_subplot()
        axes.plot([0, 1], [0, 1], "x", linestyle="")
        (line,) = axes.plot([1, 2, 3], [1, 3, 2], "o", linestyle="")
        hover(line, ['low "a" <b>', "high", "between"])

    shown = titles(draw("x", (3, 2), "three", paint))
    assert [text for _, text in shown] == ["low &quot;a&quot; &lt;b&gt;", "high", "between"]
    assert shown[1][0] < shown[2][0] < shown[0][0]  # heights of SVG grow downwards


@pytest.mark.parametrize("narrow", [False, True])
def test_parts_say_their_figures_from_the_top(narrow: bool) -> None:
    parts = [
        RankedPart("A", {}, 2.0, (1.5, 2.5), {}, True, 8, ()),
        RankedPart("B", {}, 1.0, None, {}, False, 0, ()),
    ]
    shown = dict(sorted(titles(parts_ranked(parts, {}, [], narrow=narrow))))
    assert list(shown.values()) == ["A: 2 (95 % 1.5 to 2.5), rendered in 8 scenes", "B: 1, predicted"]
