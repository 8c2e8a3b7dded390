"""The report of studies, as a plugin: importing it is light."""

from __future__ import annotations

from pathlib import Path

from tacos_framework import Command, UserError, hookimpl
from tacos_framework.files import read_json
from tacos_report import commands as report
from tacos_report.watching import commands as watch


@hookimpl
def tacos_commands() -> list[Command]:
    return [*report.commands(), *watch.commands()]


@hookimpl
def tacos_report(folder: Path) -> Path | None:
    """``report.html`` of a study; procedures write theirs themselves."""
    if _of_a_procedure(folder):
        return None
    from tacos_report import write_report

    return write_report(folder)


def _of_a_procedure(folder: Path) -> bool:
    try:
        result = read_json(folder / "result.json")
    except UserError:
        return False  # what is wrong with it is said by who reads the study
    return isinstance(result, dict) and "procedure" in result
