"""Findings of a diagnosis in a few lines, for the terminal and ``result.json``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from tacos_gap.answer.findings import Diagnosis, Parameter
from tacos_gap.report import task_words
from tacos_gap.report.limits_in_words import sentence

LIMITS_SHOWN = 5
"""Detection limits that the summary of a diagnosis without a gap names."""


def summary(
    diagnosis: Diagnosis,
    decision: Mapping[str, Any] | None = None,
    shown_from: Mapping[str, str] | None = None,
    rest: Sequence[str] = (),
) -> str:
    """Findings in a few lines.

    `shown_from`: what would have shown, by effect, for a diagnosis without a gap. `rest`: what remains, in
    sentences.
    """
    said = {
        "no_gap": "No gap: the captures differ from the simulation by no more than its own noise.",
        "explained": "Explained.",
        "partly_explained": "Partly explained: something outside the catalogue of effects remains.",
        "unknown": "Unknown: the cause lies outside the catalogue of effects.",
    }
    lines = [said[diagnosis.verdict], *rest]
    for cause in diagnosis.causes:
        values = ", ".join(_valued(name, p) for name, p in cause.parameters.items())
        low, high = cause.closure_interval
        sure = f"score {cause.present:.2f}{'' if cause.is_proven else ': fits, but is not proven'}"
        lines.append(f"  {' or '.join((cause.effect, *cause.alike))} ({sure}): {values}")
        lines.append(
            f"      added alone closes {cause.closure:.0%} of the gap ({low:.0%} to {high:.0%}), "
            f"{f'not held out: {cause.not_held_out}' if cause.not_held_out else 'held out'}"
        )
    said_before = {name for cause in diagnosis.causes for name in (cause.effect, *cause.alike)}
    more = [name for name in diagnosis.cause_set if name not in said_before]
    if more:
        lines.append(f"  cannot be told from: {', '.join(more)}")
    if len(diagnosis.causes) > 1:
        low, high = diagnosis.closure_interval
        lines.append(f"Together they close {diagnosis.closure:.0%} of the gap ({low:.0%} to {high:.0%}).")
    lines.append(f"Gap: {diagnosis.gap_before:.1f} before, {diagnosis.gap_after:.1f} after, noise floor 1.")
    lines += [task_words.sentence(name, found) for name, found in diagnosis.task.items()]
    if decision:
        lines.append(str(decision["sentence"]))
    if shown_from and diagnosis.verdict == "no_gap":
        lines += [f"  {sentence(effect, limit)}" for effect, limit in list(shown_from.items())[:LIMITS_SHOWN]]
        if (more_limits := len(shown_from) - LIMITS_SHOWN) > 0:
            lines.append(f"  The report says it of {more_limits} more.")
    if diagnosis.next_capture:
        lines.append(f"Capture next: {diagnosis.next_capture.kind}; {diagnosis.next_capture.why}.")
    return "\n".join(lines)


def _valued(name: str, parameter: Parameter) -> str:
    unit = "" if parameter.unit == "1" else f" {parameter.unit}"
    found = parameter.physical
    return f"{name} {parameter.value}{unit}" + (f" ({found.value:g} {found.unit})" if found else "")
