"""Several studies of one problem, run one after the other and put into one table."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tacos_framework import Executor, Fault, Plugins, Progress, Recipe, did_you_mean
from tacos_framework.plan import Plan, make_plan
from tacos_framework.store import DESIGNED, read_run_lines
from tacos_validation.harness import FaultsTogether, leave, result_of, study_recipe
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

    Source: The paper, Tables 1 and 2, and its supplement.
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
        return leave(out, page(outcome), outcome.as_data(), summary(outcome), table=table_csv(outcome))

    # what is compared -------------------------------------------------------------------------------------

    def plan(self, plugins: Plugins) -> tuple[list[Planned], list[str]]:
        """Every study with a plan, and notes on those left out; all faults at once, before anything runs."""
        planned: list[Planned] = []
        found = FaultsTogether()
        for name in self.config.studies:
            with found.of(f"studies.{name}", optional=name if name in self.config.optional else ""):
                recipe = self._recipe(name)
                planned.append(Planned(name, recipe, make_plan(recipe, plugins)))
                found.faults += self._missing(planned[-1])
        found.refuse()
        return planned, found.notes

    def _recipe(self, name: str) -> Recipe:
        study = self.config.studies[name]
        changes = {**self.config.change, **study.change}
        return study_recipe(study.problem or self.config.problem, changes, key="problem")

    def _missing(self, study: Planned) -> Iterator[Fault]:
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
