"""Bars of what was found: scores of the causes, and how much of the gap each closes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tacos_gap.answer.findings import Diagnosis
from tacos_gap.hypotheses.effect_names import effect_words
from tacos_gap.report.series import AFTER, BEFORE
from tacos_gap.report.words import share
from tacos_report.figures.canvas import NARROW_IN, draw, light_grid, name_rows
from tacos_report.palette import DOT, INK, MUTED, RULE, TERMS
from tacos_report.quantities import number

_LEAST_SHOWN = 0.005
_RIVALS = 3


def certainties(diagnosis: Diagnosis, *, narrow: bool = False) -> str:
    """SVG of a bar per cause, its nearest rivals below it, and *unknown* last."""
    rows: list[tuple[str, float, str]] = []  # name, score, colour
    for cause in diagnosis.causes:
        rows.append((effect_words(cause.effect), cause.present, AFTER))
        places = diagnosis.attribution.probabilities(cause.effect)
        rivals = sorted((n for n in places if n not in ("", cause.effect)), key=lambda n: -places[n])
        near = [n for n in rivals if places[n] >= _LEAST_SHOWN]
        alike = [n for n in cause.confused_with if n not in near]
        rows += [
            (f"or {effect_words(n)}", min(places.get(n, 0.0), 1 - cause.present), DOT) for n in near[:_RIVALS]
        ]
        rows += [(f"or {effect_words(n)}", cause.present, DOT) for n in alike]
    rows.append(("something unknown", diagnosis.unknown.score, TERMS[5]))
    height, top = (0.34, -0.8) if narrow else (0.62, -0.5)

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        for place, (_, score, colour) in enumerate(rows):
            axes.barh(place, 1.0, color=RULE, alpha=0.35, height=height)
            axes.barh(place, score, color=colour, height=height)
            weight = "bold" if colour == AFTER else "normal"
            text = "below 0.01" if score < _LEAST_SHOWN else f"{score:.2f}"
            axes.text(1.015, place, text, va="center", color=INK, fontweight=weight)
        names = name_rows(axes, [name for name, _, _ in rows], narrow=narrow)
        for label, (_, _, colour) in zip(names, rows, strict=True):
            label.set(
                color=INK if colour == AFTER else MUTED,
                fontweight="bold" if colour == AFTER else "normal",
                fontsize=10,
            )
        axes.set(xlim=(0, 1.32 if narrow else 1.14), ylim=(len(rows) - 0.5, top), xticks=[])
        axes.tick_params(length=0)
        axes.spines[:].set_visible(False)

    said = ", ".join(f"{name} {score:.2f}" for name, score, _ in rows)
    if narrow:
        size_in = (NARROW_IN, 0.3 + 0.48 * len(rows))
        return draw("certainties-narrow", size_in, f"Scores: {said}.", paint)
    return draw("certainties", (9.2, 0.25 + 0.36 * len(rows)), f"Scores: {said}.", paint)


def closures(diagnosis: Diagnosis, *, narrow: bool = False) -> str:
    """SVG of bars: all causes, each one's share, alone and in its place, and the negative control."""
    best = diagnosis.causes
    together = diagnosis.closure
    rows: list[tuple[str, float, str]] = []
    if len(best) > 1:
        rows.append(("all together", together, AFTER))
    for cause in best:
        if len(best) > 1:
            rows.append((f"{effect_words(cause.effect)}: its share", cause.shapley, TERMS[1]))
            rows.append(("added alone", cause.closure, TERMS[2]))
        else:
            rows.append((effect_words(cause.effect), together, AFTER))
    if diagnosis.negative_control is not None:
        rows.append(("negative control", diagnosis.negative_control.closure, DOT))
    return _bars("closures", rows, diagnosis.closure_interval, narrow=narrow)


def _bars(
    name: str, rows: Sequence[tuple[str, float, str]], interval: tuple[float, float], *, narrow: bool
) -> str:
    low = min(0.0, *(value for _, value, _ in rows))
    height, top, at_end = (0.34, -0.8, 0.16) if narrow else (0.6, -0.5, 0.075)

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        for place, (_, value, colour) in enumerate(rows):
            axes.barh(place, value, color=colour, height=height)
            end = max(value, interval[1] if place == 0 else value, 0.0)
            end = 1.0 if 1.0 - at_end < end < 1.0 else end  # not across the line of the whole gap
            axes.text(end + 0.015, place, share(value), va="center", color=INK)
        axes.plot(interval, [0, 0], color=INK, linewidth=1.2)
        axes.plot(interval, [0, 0], "|", color=INK, markersize=8)
        axes.axvline(1.0, color=MUTED, linewidth=0.9, linestyle=(0, (3, 3)))
        axes.axvline(0.0, color=RULE, linewidth=1)
        names = name_rows(axes, [label for label, _, _ in rows], narrow=narrow)
        for label, (_, _, colour) in zip(names, rows, strict=True):
            label.set(color=INK if colour != DOT else MUTED, fontsize=10)
        axes.set(ylim=(len(rows) - 0.5, top))
        axes.set_xlim(low * 1.1, 1.05 + at_end)
        axes.set_xticks([0, 0.25, 0.5, 0.75, 1.0], ["0", "25 %", "50 %", "75 %", "100 %"])
        between = "\n" if narrow else " "
        axes.set_xlabel(
            f"share of the gap above the noise floor that is gone,{between}on what was held out of the fit"
        )
        axes.spines[["left", "bottom"]].set_visible(False)
        light_grid(axes, "x")

    said = ", ".join(f"{label} {value:.2f}" for label, value, _ in rows)
    if narrow:
        return draw(f"{name}-narrow", (NARROW_IN, 0.9 + 0.48 * len(rows)), f"Closure: {said}.", paint)
    return draw(name, (9.2, 0.8 + 0.36 * len(rows)), f"Closure: {said}.", paint)


def task_scores(task: Mapping[str, Mapping[str, Any]], *, narrow: bool = False) -> str:
    """SVG of a panel per score of a task: on real frames, on simulated ones before and after."""
    order = [
        ("real", "real", INK),
        ("sim_before", "simulated", BEFORE),
        ("sim_after", "with the causes", AFTER),
    ]
    keys = {label: key for key, label, _ in order}

    def paint(figure: Figure) -> None:
        panels = figure.subplots(len(task), 1, squeeze=False)[:, 0]
        for axes, (name, values) in zip(panels, task.items(), strict=True):
            rows = [(label, values[key], colour) for key, label, colour in order if key in values]
            for place, (label, value, colour) in enumerate(rows):
                axes.barh(place, value, color=colour, height=0.6)
                end = value
                if ends := (values.get("ci") or {}).get(keys[label]):
                    axes.plot(ends, [place, place], color=MUTED, linewidth=1.4)
                    end = max(value, ends[1])
                axes.annotate(
                    number(value), (end, place), (5, 0), textcoords="offset points", va="center", color=INK
                )
            axes.axvline(values.get("real", 0.0), color=MUTED, linewidth=0.9, linestyle=(0, (3, 3)))
            axes.set_yticks(range(len(rows)), [label for label, _, _ in rows])
            axes.set(ylim=(len(rows) - 0.5, -0.5), title=name.replace(".", ": ").replace("_", " "))
            axes.set_xlim(0, (1.4 if narrow else 1.25) * max(1e-9, *(value for _, value, _ in rows)))
            axes.spines[["left", "bottom"]].set_visible(False)
            light_grid(axes, "x")

    said = "; ".join(f"{name} {dict(values)}" for name, values in task.items())
    name, width_in = ("task-scores-narrow", NARROW_IN) if narrow else ("task-scores", 7.0)
    return draw(name, (width_in, 1.35 * len(task)), f"Scores of tasks: {said}.", paint)


def decision(cameras: Sequence[Mapping[str, Any]], *, narrow: bool = False) -> str:
    """SVG of a row per camera: its fitness in the simulation as it was, and with the causes.

    `cameras`: ``camera``, and its fitness ``without`` and ``with``; None where it failed. ``ci`` holds the
    interval of either. `narrow`: for the width of a phone: cameras stand above their rows.
    """

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        for place, row in enumerate(cameras):
            known = [row[key] for key in ("without", "with") if row[key] is not None]
            axes.plot(known, [place] * len(known), color=RULE, linewidth=2.5)
            for key, mark, colour, up in (("without", "s", BEFORE, 9), ("with", "D", AFTER, -14)):
                if row[key] is not None:
                    level = place + (-0.09 if key == "without" else 0.09)
                    if ends := row.get("ci", {}).get(key):
                        axes.plot(ends, [level, level], color=colour, linewidth=1.2)
                    axes.plot([row[key]], [level], mark, color=colour, markersize=7)
                    axes.annotate(
                        number(row[key]), (row[key], level), (0, up), textcoords="offset points",
                        ha="center", color=MUTED, fontsize=8.5,
                    )  # fmt: skip
        for label in name_rows(axes, [str(row["camera"]) for row in cameras], narrow=narrow):
            label.set(color=INK, fontsize=10)
            if narrow:
                label.set_position((0, 17))  # above the numbers
        axes.set(
            ylim=(len(cameras) - 0.4, -0.9 if narrow else -0.6),
            xlabel="fitness on unseen scenes (higher is better)",
        )
        axes.margins(x=0.12)
        axes.spines[["left", "bottom"]].set_visible(False)
        light_grid(axes, "x")
        handles = [
            Line2D([], [], color=colour, marker=mark, linestyle="", markersize=7)
            for mark, colour in (("s", BEFORE), ("D", AFTER))
        ]
        names = ["as simulated before", "with the causes"]
        figure.legend(handles, names, loc="outside upper left", ncols=2, labelcolor=MUTED)

    said = ", ".join(f"{row['camera']} {row['without']} and {row['with']}" for row in cameras)
    if narrow:
        size_in = (NARROW_IN, 1.1 + 0.75 * len(cameras))
        return draw("decision-narrow", size_in, f"Fitness without and with: {said}.", paint)
    return draw("decision", (9.2, 1.0 + 0.5 * len(cameras)), f"Fitness without and with: {said}.", paint)
