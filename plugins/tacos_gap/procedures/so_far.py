"""Knowledge while a diagnosis goes on: on the terminal, and in a file that a stop leaves behind."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from tacos_framework import Fault, Progress, UserError
from tacos_framework.files import read_json
from tacos_framework.store import replace_file
from tacos_gap.answer.findings import SoFar
from tacos_gap.hypotheses.closed_forms import ClosedForm
from tacos_gap.hypotheses.effect_names import effect_words
from tacos_gap.hypotheses.kept import KeptTerm


class KeptSoFar:
    """Writes what is known so far, and says at first sight what arithmetic tells."""

    def __init__(self, path: Path, progress: Progress) -> None:
        self._path = path
        self._progress = progress
        self._is_first = True

    def __call__(self, so_far: SoFar) -> None:
        told = json.dumps(so_far.as_data(), indent=1, ensure_ascii=False) + "\n"
        replace_file(self._path, told.encode())
        if self._is_first and so_far.closed_forms:
            self._progress.step(f"At first sight: {first_sight(so_far.closed_forms)}")
        self._is_first = False

    def explanation(self) -> Sequence[KeptTerm]:
        """The explanation that a broken run had come to; empty where it had none."""
        if not self._path.exists():
            return ()
        kept = read_json(self._path)
        if not isinstance(kept, dict) or "explanation" not in kept:
            raise UserError(Fault(str(self._path), "holds no explanation", "a file that a diagnosis kept"))
        explanation: Sequence[KeptTerm] = kept["explanation"]
        return explanation


def first_sight(found: Sequence[ClosedForm]) -> str:
    """Sentence on the results of arithmetic: what is there, what is not, and what only a search can tell."""
    parts = []
    if seen := [form for form in found if form.says == "seen"]:
        parts.append(", ".join(f"{effect_words(form.effect)} {_valued(form)}" for form in seen))
    names = dict.fromkeys(form.effect for form in found)
    for says, words in (("excluded", "surely negligible"), ("open", "open")):
        alike = [n for n in names if {form.says for form in found if form.effect == n} <= {says}]
        if alike:
            parts.append(f"{words}: {', '.join(map(effect_words, alike))}")
    return "; ".join(parts) + "."


def _valued(form: ClosedForm) -> str:
    unit, found = "" if form.unit == "1" else f" {form.unit}", form.estimate
    return f"({found.parameter} {found.value:.3g} +- {found.standard_error:.1g}{unit})"
