"""Diagnosis: where a simulation parts from a real camera, why, and what closes the gap."""

from __future__ import annotations

import json
import shlex
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import JsonValue

from tacos_framework import (
    ContextMissing,
    Executor,
    Fault,
    Plugins,
    Progress,
    Settings,
    Use,
    UserError,
    setting,
)
from tacos_framework.formation import PlacedSensor
from tacos_framework.store import replace_file
from tacos_framework.study import KeepsFailing
from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.answer.findings import Diagnosis
from tacos_gap.answer.transfer import Photographed, patch, patched
from tacos_gap.answer.undiagnosed import NothingMeasured, undiagnosed_data
from tacos_gap.captures import CaptureFolder, RealCapture, read_captures
from tacos_gap.captures.processing import traces_of_processing
from tacos_gap.captures.targets.edge_tail import tails_of
from tacos_gap.hypotheses.candidates import Candidates, candidates
from tacos_gap.in_use.diagnosis import is_recording
from tacos_gap.inference.problem import placed
from tacos_gap.procedures.checks import check_all, check_captures
from tacos_gap.procedures.progress import Telling
from tacos_gap.procedures.so_far import KeptSoFar
from tacos_gap.report.limits_in_words import limits_in_words
from tacos_gap.report.one_wall import of_one_wall
from tacos_gap.report.page import Circumstances, page
from tacos_gap.report.summary import summary
from tacos_gap.report.undiagnosed import undiagnosed_page, undiagnosed_summary
from tacos_gap.simulation.bench import recipe_renderer
from tacos_gap.simulation.sensors import NODE, with_sensor
from tacos_gap.tasks import RecipeTask, default_tasks, score_tasks, task_gap, tasks_of
from tacos_gap.tasks.decision import Question, decide
from tacos_gap.tasks.recipe_tasks import frozen_plan
from tacos_plugins.building import build
from tacos_report.page import write_page
from tacos_worlds.recorded.reader import read_recording


class Diagnose:
    """Compares real captures with what a simulator expects, and names the effects it leaves out.

    Writes ``diagnosis.json`` (what was found), ``patched.yaml`` (the causes, as effects to add to a recipe
    by ``--with``) and ``report.html``. What arithmetic tells comes first, in ``so_far.json``; a run that is
    stopped goes on from what that holds with ``--resume``. Tasks are scored on the real frames and on
    simulated ones, without and with the causes: those of `task` or `study`, by default ORB features. With
    `study` it also says whether that study would choose another camera once the causes are simulated.
    """

    class Config(Settings):
        captures: str = setting(
            "captures",
            help="Folder of captures, or a recording at several exposures (times.csv) without a simulation.",
            min_length=1,
            is_path=True,
        )
        without: tuple[str, ...] = setting((), help="Effects that are not to be considered, by name.")
        sensor: Use | None = setting(
            None,
            help="The sensor that simulates the captures, e.g. {use: sensor.affine-noise}; by default the "
            "noise that captures.yaml states.",
        )
        workers: int | None = setting(
            None, help="Processes that simulate captures; by default one for each core, at most 4.", ge=1
        )
        simulations: int | None = setting(
            None,
            help="Simulations of all captures after which no further effect is looked for; by default as "
            "many as take about a minute of two cores.",
            ge=1,
        )
        study: str = setting(
            "",
            help="A study (path or name) whose cameras are ranked without and with the causes; tasks that "
            "learn keep the weights they have.",
            is_path=True,
        )
        task: str = setting(
            "",
            help="A recipe (path or name) whose tasks are scored on the captures; by default the study.",
            is_path=True,
        )
        change: dict[str, JsonValue] = setting(
            {}, help="Keys of that study's recipe to change, as with --set, e.g. {rig.binning: 8}."
        )
        evaluations: int = setting(
            4, help="Evaluations of what each of its off-the-shelf cameras leaves free, at least.", ge=1
        )
        design: int = setting(
            0, help="Evaluations to design a camera with in it; 0 leaves the designed camera out.", ge=0
        )

    def __init__(self, config: Config) -> None:
        self.config = config

    def check(self, *, plugins: Plugins) -> None:
        if is_recording(self.config.captures):
            read_recording(self.config.captures, response="estimated")
            return
        question = self._question()
        check_all(
            lambda: candidates(plugins, self.config.without),
            lambda: self._sensor(plugins),
            lambda: check_captures(self.config.captures, plugins),
            *([partial(question.check, plugins)] if question is not None else []),
            *([partial(self._tasks, plugins)] if self.config.task else []),
        )

    def run(
        self, *, out: Path, seed: int, plugins: Plugins, executor: Executor, progress: Progress, resume: bool
    ) -> Mapping[str, Any]:
        if is_recording(self.config.captures):
            return _in_use(self.config.captures, out, progress)
        began = time.monotonic()
        considered = candidates(plugins, self.config.without)
        question, tasks = self._question(), self._tasks(plugins)
        folder = self._folder(plugins, progress)
        try:
            diagnosis = self._searched(folder, considered, out, seed, progress, resume)
        except NothingMeasured as nothing:
            data = undiagnosed_data(nothing.limitations)
            _write(out, data, patched((), Photographed.of(folder.captures)))
            told = undiagnosed_page(folder, nothing.limitations, considered.effects, self._command(seed))
            write_page(out / "report.html", told)
            return {"diagnosis": data, "summary": undiagnosed_summary(nothing.limitations)}
        progress.phase("Scoring tasks", None)
        processed = traces_of_processing(folder.captures)
        rest = _named_rest(diagnosis, processed, folder.captures)
        diagnosis = _with_tasks(diagnosis, folder.captures, tasks, rest, seed)
        progress.step(", ".join(diagnosis.task) or "no captures they could be scored on")
        shown = limits_in_words(diagnosis.detectable, considered.effects, folder.captures[0].geometry)
        data = {**diagnosis.as_data(), "detectable_in_words": shown, "processed": processed}
        added = patched(diagnosis.causes, Photographed.of(folder.captures))
        _write(out, data, added)
        decision: Mapping[str, Any] = {}
        if question is not None and diagnosis.causes:
            try:
                decision = decide(question, patch(diagnosis.causes), plugins, executor, progress)
            except (ContextMissing, KeepsFailing) as missing:
                why = f"{question.study} cannot be run with the causes: {missing}."
                diagnosis = replace(diagnosis, limitations=(*diagnosis.limitations, why))
            data = {**data, "limitations": list(diagnosis.limitations), "decision": decision}
            _write(out, data, added)
        progress.phase("Drawing the report", None)
        run = Circumstances(
            seed=seed,
            command=self._command(seed),
            patch=added,
            seconds=time.monotonic() - began,
            without=self.config.without,
            decision=decision,
            considered=considered.effects,
        )
        write_page(out / "report.html", page(diagnosis, folder, run))
        return {"diagnosis": data, "summary": summary(diagnosis, decision, shown, rest)}

    def _folder(self, plugins: Plugins, progress: Progress) -> CaptureFolder:
        sensor = self._sensor(plugins)
        progress.phase("Reading captures", None)
        folder = read_captures(self.config.captures, recipe_renderer(plugins))
        if sensor is not None:
            folder = replace(folder, captures=with_sensor(folder.captures, sensor))
        progress.step(f"{len(folder.captures)} captures")
        return folder

    def _searched(
        self,
        folder: CaptureFolder,
        considered: Candidates,
        out: Path,
        seed: int,
        progress: Progress,
        resume: bool,
    ) -> Diagnosis:
        so_far = KeptSoFar(out / "so_far.json", progress)
        progress.phase("Looking for causes", None)
        with Telling(progress) as tell:
            return diagnose(
                folder,
                considered,
                seed=seed,
                workers=self.config.workers,
                notify=tell,
                simulations=self.config.simulations,
                keep=so_far,
                begun=so_far.explanation() if resume else (),
            )

    def _question(self) -> Question | None:
        config = self.config
        if not config.study:
            return None
        return Question(config.study, config.change, config.evaluations, config.design)

    def _tasks(self, plugins: Plugins) -> tuple[RecipeTask, ...]:
        """The tasks to score: of the recipe that is named for them, else of the study, else ORB features."""
        if not (named := self.config.task or self.config.study):
            return default_tasks(plugins)
        change = self.config.change if named == self.config.study else {}
        tasks = tasks_of(frozen_plan(named, change, plugins, where="task" if self.config.task else "study"))
        if not tasks:
            raise UserError(Fault("task", f"{named} has no task", "a recipe with tasks"))
        return tasks

    def _sensor(self, plugins: Plugins) -> PlacedSensor | None:
        use = self.config.sensor
        return None if use is None else PlacedSensor(use.use, NODE, build(use, "sensor", plugins))

    def _command(self, seed: int) -> str:
        default = Diagnose.Config().model_dump(mode="json")
        words = ["tacos-run", "diagnose"]
        for name, value in self.config.model_dump(mode="json").items():
            if value != default[name]:
                words += ["--set", f"{name}={json.dumps(value) if not isinstance(value, str) else value}"]
        return shlex.join([*words, "--seed", str(seed), "--out", "out"])


def _in_use(folder: str, out: Path, progress: Progress) -> Mapping[str, Any]:
    from tacos_gap.in_use.diagnosis import data_and_summary, diagnose_recording
    from tacos_gap.in_use.page import page as page_in_use

    found = diagnose_recording(folder, progress)
    replace_file(out / "diagnosis.json", (json.dumps(found.as_data(), indent=1) + "\n").encode())
    write_page(out / "report.html", page_in_use(found))
    return data_and_summary(found)


def _write(out: Path, data: Mapping[str, Any], patch: str) -> None:
    """Write each file whole or not at all: an earlier diagnosis stays where this one is broken off."""
    told = json.dumps(data, indent=1, ensure_ascii=False) + "\n"
    replace_file(out / "diagnosis.json", told.encode())
    replace_file(out / "patched.yaml", patch.encode())


def _with_tasks(
    diagnosis: Diagnosis,
    captures: Sequence[RealCapture],
    tasks: Sequence[RecipeTask],
    rest: Sequence[str],
    seed: int,
) -> Diagnosis:
    """The diagnosis with the gap of each task, and sentences on what the captures leave open."""
    causes = diagnosis.attribution.best.hypothesis
    scored = score_tasks(captures, lambda capture: placed(causes, capture.id), tasks, seed)
    scores = {name: score.as_data() for name, score in task_gap(scored).items()}
    limits = (*diagnosis.limitations, *of_one_wall(diagnosis, captures), *rest, *scored.left_out)
    return replace(diagnosis, task=scores, limitations=limits)


def _named_rest(diagnosis: Diagnosis, traces: Sequence[str], captures: Sequence[RealCapture]) -> list[str]:
    """Sentences on what remains and the captures show, though no effect of the catalogue makes it."""
    if diagnosis.verdict not in ("unknown", "partly_explained"):
        return []
    if traces:
        done = "; ".join(traces)
        return [f"These are processed files; {done}. That is the likeliest cause of what remains."]
    return tails_of(captures)
