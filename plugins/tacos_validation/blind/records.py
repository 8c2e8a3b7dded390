"""Files of a blind check: a line of JSON per case, and per commitment."""

from __future__ import annotations

from tacos_framework.store import Results
from tacos_validation.blind.cases import Case

CASES, COMMITMENTS = "cases.jsonl", "commitments.jsonl"


def kept_cases(results: Results) -> list[Case]:
    """Cases of a broken run. Raises UserError when a line is damaged."""
    return [Case.of(data) for data in results.read_lines(CASES)]
