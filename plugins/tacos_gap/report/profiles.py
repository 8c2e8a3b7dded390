"""A statistic over an axis: level, radius, frequency, period, or simply place by place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tacos_gap.evidence import Label
from tacos_gap.report.numbers import Numbers
from tacos_gap.report.series import AFTER_LINE, BAND, BEFORE_LINE, REAL_DOTS, legend
from tacos_gap.statistics.views import Over, StatisticView, place_words, position, view_of
from tacos_report.figures.canvas import NARROW_IN, draw, light_grid

MOST_PLACES = 16
_EVEN = ("dark", "flat", "bracket")
_AXES: dict[Over, tuple[str, str]] = {
    "level": ("level_dn", "expected level [DN]"),
    "radius": ("radius", "distance from the centre, over half the diagonal"),
    "frequency": ("frequency_cycles_px", "spatial frequency [cycles/px]"),
    "period": ("period_rows", "period [rows]"),
}


@dataclass(frozen=True, eq=False)
class ProfileCurve:
    """Means at each place of an axis, in the unit that is drawn."""

    title: str
    x: NDArray[np.float64]
    real: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    before: NDArray[np.float64]
    after: NDArray[np.float64]
    names: tuple[str, ...] = ()


def profile(
    name: str, numbers: Numbers, kind: Over, *, before: str, after: str | None, narrow: bool = False
) -> str:
    """SVG of real dots within the noise floor's band, and lines of the simulation before and after.

    `kind`: what the horizontal axis is; ``"places"`` sets the numbers that differ most side by side.
    """
    view = view_of(numbers.statistic)
    curves = [] if kind == "places" else _curves(numbers, kind, view)[:3]
    if max((len(curve.x) for curve in curves), default=0) < 2:  # one place is no axis
        kind, curves = "places", _places(numbers, view)

    def paint(figure: Figure) -> None:
        shape = (len(curves), 1) if narrow else (1, len(curves))
        panels = figure.subplots(*shape, squeeze=False, sharex=narrow, sharey=True).ravel()
        for axes, curve in zip(panels, curves, strict=True):
            _draw(axes, curve, joined=kind != "places", with_after=after is not None)
            axes.set_title(curve.title)
            light_grid(axes, "y")
            if kind == "places":
                axes.set_xticks(curve.x, curve.names, rotation=35 if len(curve.x) > 5 else 0,
                                ha="right" if len(curve.x) > 5 else "center", fontsize=8)  # fmt: skip
                axes.margins(x=0.08 if len(curve.x) > 3 else 0.6)
            elif not narrow or axes is panels[-1]:
                axes.set_xlabel(_AXES[kind][1])
            if kind == "period":
                axes.set_xscale("log")
                ticks = [t for t in (5, 10, 20, 50, 100, 200, 500, 1000) if t <= np.nanmax(curve.x) * 1.1]
                axes.set_xticks(ticks, [str(t) for t in ticks])
                axes.minorticks_off()
        for axes in panels if narrow else panels[:1]:
            axes.set_ylabel(view.quantity)
        legend(figure, before, after)

    size_in = (5.0, 3.1) if len(curves) == 1 else (9.2, 3.2)
    if narrow:
        name, size_in = f"{name}-narrow", (NARROW_IN, 0.7 + 2.2 * len(curves))
    return draw(name, size_in, f"{view.title}: real, {before}{f', {after}' if after else ''}.", paint)


def _draw(axes: Axes, curve: ProfileCurve, *, joined: bool, with_after: bool) -> None:
    line = {} if joined else {"linestyle": "", "markersize": 6}
    if joined and len(curve.x) > 1:
        axes.fill_between(curve.x, curve.low, curve.high, **BAND)
    else:
        span = 0.3 if not joined else max(0.02 * float(curve.x[0]), 0.5)
        for x, low, high in zip(curve.x, curve.low, curve.high, strict=True):
            axes.fill_between([x - span, x + span], low, high, **BAND)
    shift = 0.0 if joined else 0.14
    axes.plot(curve.x - shift, curve.before, **{**BEFORE_LINE, **line})
    if with_after:
        axes.plot(curve.x + shift, curve.after, **{**AFTER_LINE, **line})
    axes.plot(curve.x, curve.real, **{**REAL_DOTS, "markersize": 4.5 if joined else 6})


def _curves(numbers: Numbers, kind: Over, view: StatisticView) -> list[ProfileCurve]:
    """A curve per channel or zone, averaged over directions, and over captures that belong together."""
    key = _AXES[kind][0]
    panels: dict[str, dict[str, dict[float, list[int]]]] = {}
    for k, label in enumerate(numbers.labels):
        at = position(label.at[key])
        at = round(at, 1) if "box_px" in label.at else round(at, 4)  # tiles at nearly one radius are one
        lines = panels.setdefault(_panel(label.at, kind), {})
        lines.setdefault(_line(label, kind), {}).setdefault(at, []).append(k)
    return [_joined(title, lines, numbers, view) for title, lines in panels.items()]


def _line(label: Label, kind: Over) -> str:
    """Line of its panel that a number belongs to: levels within a scene are not those of even fields."""
    return label.capture if kind == "level" and label.kind not in _EVEN else ""


def _joined(
    title: str, lines: Mapping[str, Mapping[float, list[int]]], numbers: Numbers, view: StatisticView
) -> ProfileCurve:
    parts = [
        _curve(title, np.array(sorted(line)), [line[x] for x in sorted(line)], numbers, view)
        for line in lines.values()
    ]

    def row(name: str) -> NDArray[np.float64]:
        return np.concatenate([np.append(getattr(part, name), np.nan) for part in parts])[:-1]

    return ProfileCurve(title, row("x"), row("real"), row("low"), row("high"), row("before"), row("after"))


def _panel(at: object, kind: Over) -> str:
    assert isinstance(at, dict)
    if kind == "frequency" and "radius" in at:
        low, high = at["radius"]
        return "centre" if low == 0 else "corners" if high >= 1 else "between"
    channel = at.get("channel", "")
    return "" if channel == "mono" else str(channel)


def _curve(
    title: str,
    x: NDArray[np.float64],
    members: Sequence[Sequence[int]],
    numbers: Numbers,
    view: StatisticView,
) -> ProfileCurve:
    real, before, after = (
        np.array([_mean(values, numbers.sigma, list(kept)) for kept in members])
        for values in (numbers.real, numbers.before, numbers.after)
    )
    spread = np.array([float(np.median(numbers.sigma[list(kept)])) for kept in members])
    return ProfileCurve(
        title,
        x,
        view.shown(real),
        view.shown(real - spread),
        view.shown(real + spread),
        view.shown(before),
        view.shown(after),
    )


def _mean(values: NDArray[np.float64], sigma: NDArray[np.float64], kept: list[int]) -> float:
    return float(np.average(values[kept], weights=1 / sigma[kept] ** 2))


def _places(numbers: Numbers, view: StatisticView) -> list[ProfileCurve]:
    """The numbers of the capture that differs most, side by side."""
    names = np.array([label.capture for label in numbers.labels])
    worst = names[int(np.argmax(np.abs(numbers.z_before)))]
    own = numbers.chosen(names == worst)
    if len(own.labels) == 1 and len(names) > 1:  # one number a capture: the captures side by side
        own, places = numbers, [str(label.capture) for label in numbers.labels]
    else:
        places = [place_words(label.at) or str(label.capture) for label in own.labels]
    largest = np.sort(np.argsort(-np.abs(own.z_before))[:MOST_PLACES])
    members = [[int(k)] for k in largest]
    title = "" if own is numbers else f"in {worst}"
    curve = _curve(title, np.arange(len(largest), dtype=float), members, own, view)
    return [
        ProfileCurve(
            title, curve.x, curve.real, curve.low, curve.high, curve.before, curve.after,
            tuple(places[int(k)] for k in largest),
        )
    ]  # fmt: skip
