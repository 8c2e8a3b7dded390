"""Files of a blind check: a line of JSON per case, and per commitment."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from tacos_framework.errors import Fault, UserError
from tacos_framework.files import read_lines
from tacos_validation.blind.cases import Case

CASES, COMMITMENTS = "cases.jsonl", "commitments.jsonl"


def append(file: Path, lines: Sequence[Mapping[str, Any]]) -> None:
    """Add lines to a file."""
    with file.open("a", encoding="utf-8") as stream:
        for line in lines:
            stream.write(json.dumps(line, ensure_ascii=False) + "\n")


def read_cases(file: Path) -> Iterator[Case]:
    """Cases of a broken run; a last line that was cut off counts for nothing.

    Raises
    ------
    UserError
        When another version wrote them.
    """
    if not file.is_file():
        return
    for line in read_lines(file):
        try:
            data = json.loads(line)
        except json.JSONDecodeError:
            return
        if "fresh_gaps" not in data or "nuisance" not in data["truth"]["specification"]:
            raise UserError(
                Fault(
                    str(file),
                    "an older version of tacos-framework wrote these cases",
                    "cases of this version",
                    "Go on with that version, or start anew without --resume.",
                )
            )
        yield Case.of(data)
