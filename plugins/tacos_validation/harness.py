"""The harness of the comparisons: studies are loaded, checked together and run once; findings are left."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from tacos_framework import Executor, Fault, Plugins, Progress, Recipe, UserError, load_recipe, run
from tacos_framework.store import Results, read_run_json
from tacos_framework.study import BROKEN_OFF, DEFECT
from tacos_report.page import Page, write_page


def study_recipe(study: str, changes: Mapping[str, Any], *, key: str = "study") -> Recipe:
    """The recipe of a study with some keys changed. Raises UserError, at setting `key`, when it is none."""
    recipe = load_recipe(study, dict(changes))
    if not isinstance(recipe, Recipe):
        raise UserError(Fault(key, f"{study} is no study", "a recipe that designs"))
    return recipe


def tested_recipe(study: str, changes: Mapping[str, Any], number: int) -> Recipe:
    """The recipe of a study with some keys changed; each `number` has unseen scenes of its own.

    Raises UserError when it is no study, or has no test.
    """
    recipe = study_recipe(study, changes)
    if recipe.test is None:
        raise UserError(Fault("study", f"{study} has no test:", "scenes to be tested on"))
    test = recipe.test.model_copy(update={"seed": recipe.test.seed + number})
    return recipe.model_copy(update={"test": test})


class FaultsTogether:
    """Faults of several studies, which are raised all at once; those that are optional are noted instead."""

    def __init__(self) -> None:
        self.faults: list[Fault] = []
        self.notes: list[str] = []

    @contextmanager
    def of(self, place: str = "", *, optional: str = "") -> Iterator[None]:
        """Keep what is wrong in the body: at a place, or as a note that what is `optional` was left out."""
        try:
            yield
        except UserError as error:
            if optional:
                why = "; ".join(f"{fault.what}. {fault.remedy}".rstrip() for fault in error.faults)
                self.notes.append(f"{optional} was left out: {why}")
            elif place:
                self.faults += [replace(fault, where=f"{place}: {fault.where}") for fault in error.faults]
            else:
                self.faults += error.faults

    def refuse(self) -> None:
        """Raise what was found, those alike once: at the first place, and how many more there are."""
        places: dict[tuple[str, str, str], list[str]] = {}
        for fault in self.faults:
            places.setdefault((fault.what, fault.expected, fault.remedy), []).append(fault.where)
        if places:
            raise UserError(
                [
                    Fault(where if not more else f"{where} (and {len(more)} more like it)", *said)
                    for said, (where, *more) in places.items()
                ]
            )


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


def leave(out: Path, page: Page, data: Mapping[str, Any], summary: str, **tables: str) -> dict[str, Any]:
    """Write ``report.html`` and a CSV file for each table; returns what ``result.json`` gets."""
    write_page(out / "report.html", page)
    for name, text in tables.items():
        Results(out).write_text(f"{name}.csv", text)
    return {**data, "summary": summary}


def csv_text(heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([heads, *rows])
    return text.getvalue()
