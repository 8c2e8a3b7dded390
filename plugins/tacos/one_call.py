"""A study or a diagnosis in one call: load, run, read."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tacos_framework import load_recipe, run

if TYPE_CHECKING:
    from tacos_decision import StudyResult
    from tacos_gap.report.result_tables import DiagnosisResult


def design(
    recipe: str | Path | Mapping[str, Any],
    *,
    out: str | Path,
    sets: Mapping[str, Any] | None = None,
    resume: bool = False,
) -> StudyResult:
    """Run a study, and read what came out.

    - `recipe`: path, name of a shipped recipe, or what its file would hold.
    - `out`: the results folder: new or empty, or with `resume` that of a study to go on with.
    - `sets`: dotted keys and the values to put there, as ``--set`` does.

    Raises `UserError` when the recipe or the folder do not allow it; nothing has been computed then.
    """
    from tacos_decision import read_result

    run(load_recipe(recipe, sets), out=out, resume=resume)
    return read_result(out)


def diagnose(
    captures: str | Path, *, out: str | Path, sets: Mapping[str, Any] | None = None
) -> DiagnosisResult:
    """Diagnose a folder of captures, and read what was found.

    - `captures`: a folder with ``captures.yaml``, as ``tacos captures import`` writes it.
    - `out`: the results folder: new or empty.
    - `sets`: settings of the procedure, as ``--set`` takes them.

    Raises `UserError` when the captures or the folder do not allow it.
    """
    from tacos_gap.report.result_tables import read_diagnosis

    run(load_recipe("diagnose", {**(sets or {}), "captures": str(captures)}), out=out)
    return read_diagnosis(out)
