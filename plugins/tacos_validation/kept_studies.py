"""Studies that are part of a procedure: each is left whole in a folder, and run once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tacos_framework import Executor, Plugins, Progress, Recipe, run
from tacos_framework.store import read_run_json
from tacos_framework.study import BROKEN_OFF, DEFECT


def result_of(
    recipe: Recipe,
    folder: Path,
    *,
    plugins: Plugins,
    executor: Executor,
    resume: bool,
    accept_changes: bool = False,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """The result of a study: with `resume` that of one that ended, else what comes out now.

    One that a defect stopped has not ended: it goes on, as the defect may have been mended.

    Raises KeyboardInterrupt when the user breaks the study off: what it found is kept, and the procedure ends
    too.
    """
    done = folder / "result.json"
    if resume and done.exists():
        kept = read_run_json(done)
        if kept["stopped"] != BROKEN_OFF and not kept["stopped"].startswith(DEFECT):
            return kept
    result = run(
        recipe,
        out=folder,
        plugins=plugins,
        executor=executor,
        resume=resume and folder.exists(),
        accept_changes=accept_changes,
        progress=progress,
    )
    if result["stopped"] == BROKEN_OFF:
        raise KeyboardInterrupt
    return result
