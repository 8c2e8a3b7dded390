"""Claims, each tested by pairs of studies over many seeds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from tacos_framework import Executor, Fault, Plugins, Progress, Recipe, did_you_mean
from tacos_framework.plan import Plan, make_plan
from tacos_framework.store import DESIGNED, read_run_lines
from tacos_validation.claims.pages import ClaimsOutcome, page, summary, table_csv
from tacos_validation.claims.settings import Changes, ClaimsConfig, ClaimStudy, study_and_camera
from tacos_validation.claims.verdicts import judged
from tacos_validation.harness import FaultsTogether, leave, result_of, tested_recipe
from tacos_validation.studies_table.findings import StudyRun


@dataclass(frozen=True, eq=False)
class PlannedStudy:
    """A study under one scoring, with one seed."""

    name: str
    scoring: str
    seed: int
    recipe: Recipe

    @property
    def folder(self) -> str:
        return f"studies/{self.scoring.replace(' ', '_')}-{self.name}-{self.seed}"


class ClaimsTested:
    """Runs the studies of some claims with many seeds, and says of each claim whether it holds.

    Seeds go one after the other, each with all studies. Every study is left whole under ``studies/``. A
    broken run goes on with ``--resume``: studies that are done are read.
    """

    Config = ClaimsConfig

    def __init__(self, config: ClaimsConfig) -> None:
        self.config = config.without_skipped()

    def check(self, *, plugins: Plugins, seed: int) -> None:
        self._planned(plugins, seed)

    def run(
        self,
        *,
        out: Path,
        seed: int,
        plugins: Plugins,
        executor: Executor,
        progress: Progress,
        resume: bool,
        accept_changes: bool = False,
    ) -> Mapping[str, Any]:
        studies, notes = self._planned(plugins, seed)
        progress.phase("Running studies", len(studies))
        result = partial(
            result_of, plugins=plugins, executor=executor, resume=resume, accept_changes=accept_changes
        )
        runs: dict[str, dict[str, dict[int, StudyRun]]] = {scoring: {} for scoring in self.config.scorings}
        for study in studies:
            folder = out / study.folder
            found = result(study.recipe, folder)
            run = StudyRun(study.name, study.seed, found, read_run_lines(folder / "generations.jsonl"))
            runs[study.scoring].setdefault(study.name, {})[study.seed] = run
            progress.step(f"{study.name}, {study.scoring}, seed {study.seed}")
        outcome = self._judge(runs, notes)
        return leave(out, page(outcome), outcome.as_data(), summary(outcome.found), claims=table_csv(outcome))

    def _judge(
        self, runs: Mapping[str, Mapping[str, Mapping[int, StudyRun]]], notes: Sequence[str]
    ) -> ClaimsOutcome:
        every = [run for studies in runs.values() for seeds in studies.values() for run in seeds.values()]
        undesigned = sum(DESIGNED not in run.result["test"] for run in every)
        if undesigned:
            notes = [*notes, f"{undesigned} studies found no camera; claims about it go without their seeds."]
        return ClaimsOutcome(
            self.config,
            tuple(
                judged(name, claim, scoring, runs[scoring], self.config.confidence)
                for name, claim in self.config.claims.items()
                for scoring in self.config.scorings
            ),
            studies=len(every),
            images=sum(int(run.result["frames_rendered"]) for run in every),
            seconds=sum(float(run.result["seconds"]) for run in every),
            notes=tuple(notes),
        )

    def _planned(self, plugins: Plugins, seed: int) -> tuple[list[PlannedStudy], list[str]]:
        """Every study, and notes on those left out; all faults at once, before anything runs."""
        planned: list[PlannedStudy] = []
        faults = FaultsTogether()
        for name, study in self.config.studies.items():
            for scoring, changes in self.config.scorings.items():
                with faults.of(f"studies.{name}", optional=name if name in self.config.optional else ""):
                    for number in range(self.config.seeds):
                        recipe = tested_recipe(study.study, self._keys(study, changes, seed + number), number)
                        if number == 0:
                            faults.faults += self._unknown_cameras(name, make_plan(recipe, plugins))
                        planned.append(PlannedStudy(name, scoring, seed + number, recipe))
        faults.refuse()
        return sorted(planned, key=lambda each: each.seed), list(dict.fromkeys(faults.notes))

    def _keys(self, study: ClaimStudy, scoring: Mapping[str, Changes], seed: int) -> dict[str, Any]:
        throughout, scored = self.config.change.get(study.study, {}), scoring.get(study.study, {})
        return {**throughout, **scored, **study.change, "seed": seed}

    def _unknown_cameras(self, study: str, plan: Plan) -> Iterator[Fault]:
        known = [DESIGNED, *(camera.name for camera in plan.cameras)]
        for name, claim in self.config.claims.items():
            for named in (claim.of, *claim.over):
                of, camera = study_and_camera(named)
                if of == study and camera not in known:
                    yield Fault(
                        f"claims.{name}",
                        f"study {study} compares with no camera {camera!r}",
                        f"one of {', '.join(known)}",
                        did_you_mean(camera, known),
                    )
