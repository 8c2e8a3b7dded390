"""The report of a blind check."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure as Canvas

from tacos_report.figures.canvas import draw, light_grid
from tacos_report.page import Drawing, Page, Paragraph, Section, Table, Warnings
from tacos_report.palette import INK, MUTED, PAPER, camera_colour
from tacos_validation.blind.cases import Case
from tacos_validation.blind.scoring import Figure, baselines, ladder

OTHERWISE = ("no_gap", "unknown", "partly_explained", "error")


def page(cases: Sequence[Case], figures: Sequence[Figure], notes: Sequence[str]) -> Page:
    """The page: confusion first, then the goals, the ladder, simpler ways, and every failure."""
    goals = [figure for figure in figures if figure.met is not None]
    met = sum(bool(figure.met) for figure in goals)
    warnings = (Section("Notes", (Warnings("What to know", tuple(notes)),)),) if notes else ()
    return Page(
        eyebrow="Diagnosis, checked blind",
        title=f"{met} of {len(goals)} goals met over {len(cases)} cases",
        lead=(
            "Captures of cameras with withheld effects, made by another code path in another process; their "
            "truth was salted and hashed before the diagnosis began and opened after its answer was "
            "written. Intervals are 95 %, of shares exact (Clopper and Pearson)."
        ),
        sections=(
            Section("What was withheld, and what was named first", tuple(_confusions(cases))),
            Section("Figures and goals", (_goals(figures),)),
            Section("Severity", (_ladder(cases),)) if ladder(cases) else Section("Severity", ()),
            Section("Simpler ways on the same cases", (_simpler(cases),)),
            *warnings,
            Section("Failures", (_failures(cases),)),
        ),
    )


def _confusions(cases: Sequence[Case]) -> list[Drawing]:
    return [
        drawing
        for title, chosen in (
            ("charts", [c for c in cases if c.tier == "T1" and c.captures != "natural"]),
            ("natural scenes alone", [c for c in cases if c.tier == "T1" and c.captures == "natural"]),
            ("independent makers", [c for c in cases if c.tier == "T4"]),
        )
        if (drawing := _confusion(title, chosen)) is not None
    ]


def _confusion(title: str, cases: Sequence[Case]) -> Drawing | None:
    if not cases:
        return None
    rows = sorted({case.effects[0] for case in cases})
    columns = sorted(set(rows) | {case.first for case in cases if case.first not in OTHERWISE})
    columns += [name for name in OTHERWISE if any(case.first == name for case in cases)]
    counts = np.zeros((len(rows), len(columns)))
    for case in cases:
        counts[rows.index(case.effects[0]), columns.index(case.first)] += 1
    shares = counts / counts.sum(axis=1, keepdims=True)

    def paint(figure: Canvas) -> None:
        axes = figure.add_subplot()
        scale = LinearSegmentedColormap.from_list("share", [PAPER, camera_colour(1)])
        axes.pcolormesh(shares, cmap=scale, vmin=0, vmax=1, edgecolors=PAPER, linewidth=0.5)
        for row, column in zip(*np.nonzero(counts), strict=True):
            axes.text(
                column + 0.5, row + 0.5, f"{counts[row, column]:g}", ha="center", va="center", fontsize=7,
                color=PAPER if shares[row, column] > 0.5 else INK,
            )  # fmt: skip
        axes.set_xticks(np.arange(len(columns)) + 0.5, columns, rotation=90, fontsize=7)
        axes.set_yticks(np.arange(len(rows)) + 0.5, rows, fontsize=7)
        axes.invert_yaxis()
        axes.set_xlabel("named first")
        axes.set_ylabel("withheld")
        axes.set_title(title)
        axes.tick_params(length=0)

    height = 2.6 + 0.19 * len(rows)
    svg = draw(f"confusion-{title}", (9.2, height), f"Withheld effects against those named, {title}.", paint)
    return Drawing(svg, f"{title.capitalize()}: numbers are cases of all severities.")


def _goals(figures: Sequence[Figure]) -> Table:
    rows = tuple(
        (each.name, _shown(each), _ends(each), str(each.count), each.goal, _met(each)) for each in figures
    )
    caption = "T1 to T3 count cases whose severity came out at 4 units or more; medians with their intervals."
    return Table(("Figure", "Found", "95 %", "Of", "Goal", "Met"), rows, caption)


def _met(figure: Figure) -> str:
    if figure.met is None:
        return "no cases" if figure.goal else ""
    return "yes" if figure.met else "no"


def _number(value: float, unit: str) -> str:
    if math.isnan(value):
        return "–"
    return f"{value:.1%}" if unit == "%" else f"{value:.2f}{unit}"


def _shown(figure: Figure) -> str:
    return _number(figure.value, figure.unit)


def _ends(figure: Figure) -> str:
    if math.isnan(figure.low):
        return ""
    return f"{_number(figure.low, figure.unit)} to {_number(figure.high, figure.unit)}"


def _ladder(cases: Sequence[Case]) -> Drawing:
    steps = ladder(cases)

    def paint(figure: Canvas) -> None:
        axes = figure.add_subplot()
        at = [severity for severity, _ in steps]
        values = np.array([each.value for _, each in steps])
        ends = np.array([[each.low, each.high] for _, each in steps]).T
        axes.errorbar(
            at, values, yerr=np.abs(ends - values), color=camera_colour(1), marker="o", capsize=3, linewidth=2
        )
        axes.axhline(0.95, color=MUTED, linewidth=1, linestyle="--")
        axes.set_xscale("log", base=2)
        axes.set_xticks(at, [f"{value:g}" for value in at])
        axes.set_ylim(0, 1.02)
        axes.set_xlabel("severity [noise floor]")
        axes.set_ylabel("first cause right")
        light_grid(axes, "y")

    described = "Share of cases with the right first cause against the severity of the withheld effect."
    return Drawing(
        draw("ladder", (7.0, 3.2), described, paint), "T1 with charts. Dashed: the goal from 4 units on."
    )


def _simpler(cases: Sequence[Case]) -> Table:
    table = baselines(cases)
    heads = ("Way", *next(iter(table.values())))
    rows = tuple(
        (way, *(f"{_shown(f)} of {f.count}" for f in figures.values())) for way, figures in table.items()
    )
    return Table(heads, rows, "The first cause at 4 units or more; false alarms: anything named at all.")


def _failures(cases: Sequence[Case]) -> Table | Paragraph:
    wrong = [case for case in cases if not case.right]
    if not wrong:
        return Paragraph("None.")
    rows = tuple(_failure(case) for case in sorted(wrong, key=lambda c: (c.tier, c.captures, c.effects)))
    heads = ("Case", "Tier", "Captures", "Withheld", "Severity", "Answer", "Set", "Gap before and after")
    return Table(heads, rows, f"{len(wrong)} of {len(cases)} cases, none left out; all stand in cases.jsonl.")


def _failure(case: Case) -> tuple[str, ...]:
    specification: Mapping[str, object] = case.truth["specification"]
    withheld = ", ".join(case.effects) or "nothing"
    makers = ", ".join(dict(specification.get("variants") or {}).values())  # type: ignore[call-overload]
    answer = case.answer
    if case.failed:
        said, gap = str(answer["error"]), ""
    else:
        said = ", ".join(f"{c['effect']} ({c['probability']:.0%})" for c in answer["causes"])
        said = f"{answer['verdict']}: {said}" if said else str(answer["verdict"])
        gap = f"{answer['gap']['before']:.2f}, {answer['gap']['after']:.2f}"
    return (
        case.name,
        case.tier,
        case.captures,
        f"{withheld} ({makers})" if makers else withheld,
        f"{case.units:.1f}",
        said,
        ", ".join(case.cause_set),
        gap,
    )
