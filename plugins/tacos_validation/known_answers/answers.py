"""Jobs stated by their physics, and whether studies find what engineers use for them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal

from pydantic import JsonValue

from tacos_framework import (
    Executor,
    Fault,
    Plugins,
    Progress,
    Recipe,
    Settings,
    UserError,
    did_you_mean,
    setting,
)
from tacos_framework.plan import Plan, make_plan
from tacos_validation.harness import FaultsTogether, leave, result_of, study_recipe
from tacos_validation.known_answers.agreement import PointHeld, held
from tacos_validation.known_answers.industry import (
    SHIPPED,
    IndustryAnswer,
    System,
    industry_answer,
    read_systems,
)
from tacos_validation.known_answers.pages import page, summary

PointName = Literal["shutter", "colour", "pixel", "pixels", "field", "baseline"]


class KnownJob(Settings):
    """A job, the study that states it, and what its systems are held to."""

    study: str = setting(
        help="The recipe that states the job: a path, or the name of a shipped one.", is_path=True
    )
    change: dict[str, JsonValue] = setting(
        {}, help="Keys of that recipe to change, as with --set: what the study may choose from."
    )
    systems: tuple[str, ...] = setting(help="Jobs of the table whose systems do this job.", min_length=1)
    leave_out: dict[str, str] = setting(
        {}, help="Systems of these that do not count, with the reason: another job, or no choice."
    )
    points: tuple[PointName, ...] = setting(
        help="Points to compare with the industry's answer.", min_length=1
    )


@dataclass(frozen=True, eq=False)
class PlannedJob:
    """A job that can be run, with the industry's answers."""

    name: str
    recipe: Recipe
    plan: Plan
    answers: tuple[IndustryAnswer, ...]
    absent: tuple[str, ...]
    """Points at which the systems state nothing, or no one thing."""


class KnownAnswers:
    """Runs a study for each job, and holds its posterior against what engineers use for that job.

    A class is a word that three quarters of the systems have, or the range of their numbers widened by a
    stated factor. The probability of a class is the share of joint draws of the study's posterior in which
    the best camera is of that class. A broken run goes on with ``--resume``; jobs that are done are kept.
    """

    class Config(Settings):
        data: str = setting(
            "",
            help="CSV file of systems with the columns job, system, shutter, colour, pixel_um, width_px, "
            "height_px, hfov_deg, baseline_mm; empty: the one that ships.",
            is_path=True,
        )
        evaluations: int = setting(
            60, help="Cameras that each study simulates; fewer for a quick look.", ge=2
        )
        jobs: dict[str, KnownJob] = setting(help="Jobs by name.", min_length=1)

    def __init__(self, config: Config) -> None:
        self.config = config

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
        jobs = self._planned(plugins, seed)
        progress.phase("Running studies", len(jobs))
        points: list[PointHeld] = []
        result = partial(
            result_of, plugins=plugins, executor=executor, resume=resume, accept_changes=accept_changes
        )
        for job in jobs:
            found = result(job.recipe, out / "studies" / job.name)
            points += [held(job.name, answer, found, job.plan) for answer in job.answers]
            progress.step(job.name)
        not_asked = {job.name: list(job.absent) for job in jobs if job.absent}
        data = {
            "jobs": [each.as_data() for each in points],
            "agreement": sum(each.agrees for each in points) / len(points),
            "by_chance": sum(each.chance for each in points) / len(points),
            "not_stated": not_asked,
        }
        return leave(out, page(points, not_asked), data, summary(points))

    def _planned(self, plugins: Plugins, seed: int) -> list[PlannedJob]:
        """Every job with its plan and answers; all faults at once."""
        systems = read_systems(Path(self.config.data) if self.config.data else SHIPPED)
        faults = FaultsTogether()
        planned = []
        for name, job in self.config.jobs.items():
            faults.faults += _faults_of(name, job, systems)
            with faults.of(f"jobs.{name}"):
                recipe = self._recipe(job, seed)
                own = [
                    row for row in systems if row["job"] in job.systems and row["system"] not in job.leave_out
                ]
                found = {point: industry_answer(point, own) for point in job.points}
                answers = tuple(answer for answer in found.values() if answer is not None)
                absent = tuple(point for point, answer in found.items() if answer is None)
                planned.append(PlannedJob(name, recipe, make_plan(recipe, plugins), answers, absent))
        if not faults.faults and not any(job.answers for job in planned):
            raise UserError(Fault("data", "its systems state no point of any job", "systems with values"))
        faults.refuse()
        return planned

    def _recipe(self, job: KnownJob, seed: int) -> Recipe:
        changes = {**job.change, "seed": seed, "optimizer.evaluations": self.config.evaluations}
        return study_recipe(job.study, changes).model_copy(update={"compare": None, "test": None})


def _faults_of(name: str, job: KnownJob, systems: Sequence[System]) -> Iterator[Fault]:
    """Names in a job that the table does not have."""
    known = {row["job"] for row in systems}
    for own in job.systems:
        if own not in known:
            yield Fault(f"jobs.{name}.systems", f"the table has no job {own!r}", "", did_you_mean(own, known))
    named = {row["system"] for row in systems}
    for own in job.leave_out:
        if own not in named:
            yield Fault(
                f"jobs.{name}.leave_out", f"the table has no system {own!r}", "", did_you_mean(own, named)
            )
