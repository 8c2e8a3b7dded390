"""Files of a blind check: a line of JSON per case, and per commitment, each with its checksum."""

from __future__ import annotations

from tacos_framework.results import Results
from tacos_validation.blind.cases import Case

CASES, COMMITMENTS = "cases.jsonl", "commitments.jsonl"


def kept_cases(results: Results) -> list[Case]:
    """Cases of a broken run; a last line that was cut short goes, in both files.

    Raises
    ------
    UserError
        When a line is damaged.
    """
    for name in (CASES, COMMITMENTS):
        results.write_lines(name, results.read_lines(name))
    return [Case.of(data) for data in results.read_lines(CASES)]
