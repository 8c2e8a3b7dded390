"""The report of a blind check."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from tacos_report.page import Block, Page, Paragraph, Section, SideBySide, Table, Warnings
from tacos_validation.blind.cases import Case
from tacos_validation.blind.confusion import confusions
from tacos_validation.blind.drawings import interval_coverage, reliability_diagrams, severities
from tacos_validation.blind.figure import Figure
from tacos_validation.blind.judgement import sureness
from tacos_validation.blind.scoring import baselines, by_nuisance, ladder


def page(cases: Sequence[Case], figures: Sequence[Figure], notes: Sequence[str]) -> Page:
    goals = [figure for figure in figures if figure.met is not None]
    met = sum(bool(figure.met) for figure in goals)
    sections = (
        Section("What was withheld, and what was named first", tuple(confusions(cases))),
        Section("Figures and goals", (_goals(figures),)),
        Section("Does its certainty hold?", tuple(_calibration(cases))),
        Section("Severity", (severities(cases),) if ladder(cases) else ()),
        Section("Nuisances", tuple(_nuisances(cases))),
        Section("Real cameras", tuple(_real(cases))),
        Section("Simpler ways on the same cases", tuple(_simpler(cases))),
        Section("Notes", (Warnings("What to know", tuple(notes)),) if notes else ()),
        Section("Failures", (_failures(cases),)),
    )
    return Page(
        eyebrow="Diagnosis, checked blind",
        title=f"{met} of {len(goals)} goals met over {len(cases)} cases",
        lead=(
            "Captures of cameras with withheld effects, made by another code path in another process; their "
            "truth was salted and hashed before the diagnosis began and opened after its answer was "
            "written. Intervals are 95 %, of shares exact (Clopper and Pearson)."
        ),
        sections=tuple(section for section in sections if section.blocks),
    )


def _calibration(cases: Sequence[Case]) -> list[Block]:
    diagrams = reliability_diagrams(cases)
    intervals = interval_coverage(cases)
    shown = tuple(diagrams if intervals is None else [*diagrams, intervals])
    return [SideBySide(shown)] if shown else []


def _nuisances(cases: Sequence[Case]) -> list[Block]:
    rows = [
        (
            name,
            _of(told),
            _of(quiet),
            str(sum(case.confident_and_wrong for case in own)),
            str(sum(case.failed for case in own)),
        )
        for name, (told, quiet, own) in by_nuisance(cases).items()
    ]
    if not rows:
        return []
    heads = ("What was off", "First cause right", "Right, nothing withheld", "Wrong and sure", "No answer")
    return [Table(heads, tuple(rows), "T7; the first column of figures at 4 units or more.")]


def _real(cases: Sequence[Case]) -> list[Block]:
    real = sorted((case for case in cases if case.tier == "T5"), key=lambda case: case.name)
    rows = [
        (case.name, judgement.outcome, _said(case), ", ".join(known.accept))
        for case in real
        if (judgement := case.judgement) and (known := case.known)
    ]
    heads = ("Captures", "Outcome", "Answer", "Known")
    return [Table(heads, tuple(rows), "T5: all, right and wrong.")] if rows else []


def _of(figure: Figure) -> str:
    return f"{_shown(figure)} of {figure.count}"


def _goals(figures: Sequence[Figure]) -> Table:
    rows = tuple(
        (each.name, _shown(each), _ends(each), str(each.count), each.goal, _met(each)) for each in figures
    )
    caption = "T1, T3, T4 and T7 count cases whose severity came out at 4 units or more."
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


def _simpler(cases: Sequence[Case]) -> list[Block]:
    if not any(case.answer.get("baselines") for case in cases):
        return []
    table = baselines(cases)
    heads = ("Way", *next(iter(table.values())))
    rows = tuple((way, *(_of(each) for each in figures.values())) for way, figures in table.items())
    return [Table(heads, rows, "The first cause at 4 units or more; false alarms: anything named at all.")]


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
    beside = f", with: {case.nuisance}" if case.nuisance else ""
    gap = case.answer.get("gap")
    return (
        case.name,
        case.tier,
        case.captures,
        f"{withheld} ({makers})" if makers else f"{withheld}{beside}",
        f"{case.units:.1f}",
        _said(case),
        ", ".join(case.cause_set),
        f"{gap['before']:.2f}, {gap['after']:.2f}" if gap else "",
    )


def _said(case: Case) -> str:
    if case.failed:
        return str(case.answer["error"])
    causes = ", ".join(f"{each['effect']} ({sureness(each):.0%})" for each in case.answer["causes"])
    return f"{case.answer['verdict']}: {causes}" if causes else str(case.answer["verdict"])
