"""Several studies of one problem, run one after the other and put into one table."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tacos_framework import Executor, Fault, Plugins, Progress, Recipe, UserError, did_you_mean, load_recipe
from tacos_framework.plan import Plan, make_plan
from tacos_framework.store import DESIGNED, Results, read_run_lines
from tacos_report.page import write_page
from tacos_validation.kept_studies import result_of
from tacos_validation.studies_table.findings import StudyRun, findings
from tacos_validation.studies_table.pages import TableOutcome, folder_of, page, summary, table_csv
from tacos_validation.studies_table.settings import StudiesConfig

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Planned:
    """A study that can be run."""

    name: str
    recipe: Recipe
    plan: Plan


class StudiesTable:
    """Runs studies that differ in a few keys, and sets what they find beside published figures.

    Joint or frozen weights, one optimizer or another, day or night: each is the same recipe with some keys
    changed. Every study leaves its full results folder under ``studies/``; all are compared on the test
    scenes of the problem, and a table in the shape one asks for collects their cameras.

    A broken run goes on with ``--resume``: studies that were finished are read, the broken one goes on.

    References
    ----------
    The paper, Tables 1 and 2, and its supplement.
    """

    Config = StudiesConfig

    def __init__(self, config: StudiesConfig) -> None:
        self.config = config

    def check(self, *, plugins: Plugins) -> None:
        self.plan(plugins)

    def run(
        self,
        *,
        out: Path,
        plugins: Plugins,
        executor: Executor,
        progress: Progress,
        resume: bool,
        accept_changes: bool = False,
    ) -> Mapping[str, Any]:
        planned, notes = self.plan(plugins)
        runs = tuple(self._runs(planned, out, plugins, executor, progress, resume, accept_changes))
        rows = findings(self.config.rows, self.config.columns, runs)
        outcome = TableOutcome(self.config, rows, runs, tuple(notes))
        write_page(out / "report.html", page(outcome))
        Results(out).write_text("table.csv", table_csv(outcome))
        return {**outcome.as_data(), "summary": summary(outcome)}

    # what is compared -------------------------------------------------------------------------------------

    def plan(self, plugins: Plugins) -> tuple[list[Planned], list[str]]:
        """Every study with a plan, and notes on those left out; all faults at once, before anything runs."""
        planned: list[Planned] = []
        notes: list[str] = []
        faults: list[Fault] = []
        for name in self.config.studies:
            try:
                recipe = self._recipe(name)
                study = Planned(name, recipe, make_plan(recipe, plugins))
            except UserError as error:
                if name in self.config.optional:
                    why = "; ".join(f"{fault.what}. {fault.remedy}".rstrip() for fault in error.faults)
                    notes.append(f"{name} was left out: {why}")
                else:
                    faults.extend(
                        Fault(f"studies.{name}: {fault.where}", fault.what, fault.expected, fault.remedy)
                        for fault in error.faults
                    )
                continue
            planned.append(study)
            faults.extend(self._missing(study))
        if faults:
            raise UserError(_once(faults))
        return planned, notes

    def _recipe(self, name: str) -> Recipe:
        study = self.config.studies[name]
        problem = study.problem or self.config.problem
        recipe = load_recipe(problem, {**self.config.change, **study.change})
        if not isinstance(recipe, Recipe):
            raise UserError(Fault("problem", f"{problem} is no study", "a recipe that designs"))
        return recipe

    def _missing(self, study: Planned) -> Iterator[Fault]:
        """Demands of rows and columns on a study that it will not meet."""
        cameras = [DESIGNED, *(camera.name for camera in study.plan.cameras)]
        for number, row in enumerate(self.config.rows):
            if row.study == study.name and row.camera not in cameras:
                yield Fault(
                    f"rows.{number}.camera",
                    f"study {study.name} has no camera {row.camera!r}",
                    f"one of {', '.join(cameras)}",
                    did_you_mean(row.camera, cameras),
                )
        if study.recipe.test is None and any(c.value.startswith("test.") for c in self.config.columns):
            yield Fault(
                f"studies.{study.name}",
                "its recipe has no test scenes, and columns show scores on them",
                "test: {seed: ...}",
            )

    # running ----------------------------------------------------------------------------------------------

    def _runs(
        self,
        planned: Sequence[Planned],
        out: Path,
        plugins: Plugins,
        executor: Executor,
        progress: Progress,
        resume: bool,
        accept_changes: bool,
    ) -> Iterator[StudyRun]:
        for number in range(self.config.seeds):
            for study in planned:
                seed = study.recipe.seed + number
                folder = out / folder_of(study.name, seed)
                log.info("study %s, seed %d", study.name, seed)
                result = result_of(
                    study.recipe.model_copy(update={"seed": seed}),
                    folder,
                    plugins=plugins,
                    executor=executor,
                    resume=resume,
                    accept_changes=accept_changes,
                    progress=progress,
                )
                yield StudyRun(study.name, seed, result, read_run_lines(folder / "generations.jsonl"))


def _once(faults: Sequence[Fault]) -> list[Fault]:
    """The faults, those alike said once: at the first place, and how many more there are."""
    places: dict[tuple[str, str, str], list[str]] = {}
    for fault in faults:
        places.setdefault((fault.what, fault.expected, fault.remedy), []).append(fault.where)
    return [
        Fault(where if not more else f"{where} (and {len(more)} more like it)", *said)
        for said, (where, *more) in places.items()
    ]
