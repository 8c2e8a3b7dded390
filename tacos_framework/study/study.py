"""The study: design a camera, search what off-the-shelf cameras leave free, judge all on unseen scenes."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import __version__
from tacos_framework.cache import content_key
from tacos_framework.camera.colour import display_image
from tacos_framework.contracts import Executor, JobRunner, State
from tacos_framework.environment import describe_environment
from tacos_framework.fitness import standard_errors
from tacos_framework.plan import Plan, make_plan
from tacos_framework.plan.notes import inadmissible, notes_on_camera, notes_on_constraints
from tacos_framework.plugins import Plugins
from tacos_framework.plugins.executing import GuardedExecutor
from tacos_framework.recipe import Recipe
from tacos_framework.results import Results
from tacos_framework.simulation import EpisodeSpec, Evaluation, Evaluator, SampleJob, ScoreJob
from tacos_framework.study.failing import KeepsFailing
from tacos_framework.study.progress import Progress, Silent
from tacos_framework.study.search import Search, as_data
from tacos_framework.study.shards import score_sharded
from tacos_framework.values import FrameBatch

log = logging.getLogger(__name__)

DESIGNED = "designed"
"""Name of the designed camera in results."""

SAMPLES_AT = (0.15, 0.5, 0.85)
"""Where along the test episode sample frames are taken [share of the episode]."""

BROKEN_OFF = "interrupted by the user"
"""Why a study stopped that was broken off with Ctrl-C, as its result says."""

DEFECT = "stopped by a defect"
"""Begins why a study stopped whose candidates kept failing by the same defect of a component."""


def run_study(
    study: Recipe | Plan,
    *,
    out: Path,
    plugins: Plugins,
    executor: JobRunner | None = None,
    resume: bool = False,
    progress: Progress | None = None,
    command: str = "",
    report: bool = True,
) -> dict[str, Any]:
    """Run a study; see `tacos_framework.run`."""
    plan = study if isinstance(study, Plan) else make_plan(study, plugins)
    data = plan.recipe.as_data()
    results, checkpoint = Results.resume(out, data) if resume else (Results.create(out, data), None)
    parts = [*plan.nodes.values(), plan.optimizer, plan.executor]
    packages = {part.cls.__module__.partition(".")[0] for part in parts}
    with results, results.logging({"tacos_framework", *packages}):
        of_recipe, distribution = plan.executor, plan.executor.distribution
        evaluates = (
            GuardedExecutor.of_host(executor)
            if executor
            else GuardedExecutor(of_recipe.make(), of_recipe.use, distribution)
        )
        running = Study(plan, plugins, results, evaluates, progress or Silent(), command)
        try:
            running.restore(checkpoint)
            running.run()
        except KeyboardInterrupt:
            running.broken_off = BROKEN_OFF
            log.warning("Interrupted. What was computed is kept; --resume goes on from there.")
        except KeepsFailing as error:
            running.broken_off = f"{DEFECT}: {error}"
            log.error("%s", running.broken_off)
        finally:
            if executor is None:
                evaluates.close()
        result = running.finish()
        if report:
            from tacos_framework.report import write_report

            with results.writing():
                write_report(results.folder)
    return result


class Study:
    """One run of a recipe; see `run_study`."""

    def __init__(
        self,
        plan: Plan,
        plugins: Plugins,
        results: Results,
        executor: Executor,
        progress: Progress,
        command: str = "",
    ):
        self.plan = plan
        self.results = results
        self.broken_off: str | None = None
        self._observers = plugins.observers()
        self._executor = executor
        self._progress = progress
        self._command = command
        self._evaluate = Evaluator(plan, plugins)
        self._seconds_before = 0.0
        self._started = time.monotonic()
        self._seconds_by_node: dict[str, float] = {}
        self._test: dict[str, Evaluation] = {}
        self._samples: dict[str, list[str]] = {}
        workers = getattr(executor, "workers", 1)
        self._environment = describe_environment(workers, plugins.findings())
        self._inadmissible = inadmissible(plan)
        self._notes_on_constraints = tuple(notes_on_constraints(plan))
        self.searches = list(self._make_searches())

    def _make_searches(self) -> Iterator[Search]:
        states = self._evaluate.simulation.initial_states() if self.plan.trainable else {}
        yield Search(DESIGNED, self.plan, self.plan.space, {}, None, dict(states))
        budget = self.plan.recipe.compare.evaluations if self.plan.recipe.compare else None
        for camera in self.plan.cameras:
            free = self.plan.free_of(camera)
            space = free if free.variables else None
            yield Search(camera.name, self.plan, space, dict(camera.fixes), budget, dict(states))

    # running ----------------------------------------------------------------------------------------------

    def run(self) -> None:
        """Search, then judge; each step checkpointed."""
        log.info("%s", self._command or self.plan.recipe.name)
        for name, value in self._environment["findings"].items():
            log.info("%s: %s", name, value)
        self._observers.tell("tacos_study_started", recipe=self.plan.recipe, out=self.results.folder)
        for search in self.searches:
            self._search(search)
        self._train_best()
        self._judge()

    def _search(self, search: Search) -> None:
        if search.finalists_rescored:
            return
        title = "Designing" if search.name == DESIGNED else f"Fitting {search.name}"
        self._progress.phase(title, search.expected_candidates())
        while not search.stopped:
            began = time.monotonic()
            number = search.generation
            try:
                evaluations = search.step(self._executor, self._evaluate, self._count)
            except KeepsFailing as error:
                if search.name == DESIGNED:  # shown; --resume asks for this generation again
                    self._record(number, search, error.evaluations, time.monotonic() - began)
                raise
            if search.name == DESIGNED and evaluations:
                self._record(number, search, evaluations, time.monotonic() - began)
                best = search.best
                self._observers.tell(
                    "tacos_generation_finished", generation=number, evaluated=evaluations, best=best
                )
                log.info("generation %d: best %s", number, best and best.fitness)
            self._progress.best(search.best)
            self._checkpoint()
        search.rescore_finalists(self._executor, self._evaluate, self._count)
        self._progress.best(search.best)
        self._checkpoint()
        log.info("%s: %s; best fitness %s", search.name, search.stopped, search.best and search.best.fitness)

    def _train_best(self) -> None:
        """Train each camera's network further on that camera; the cameras at the same time."""
        trainings = self.plan.recipe.study.train_best
        if any(search.next_training_on_best() for search in self.searches):
            self._progress.phase("Training on the best", trainings * len(self.searches))
        while pending := [(s, job) for s in self.searches if (job := s.next_training_on_best()) is not None]:
            trained = self._executor.map(self._evaluate, [job for _, job in pending])
            for (search, _), evaluation in zip(pending, trained, strict=True):
                self._account(evaluation)
                self._progress.step()
                search.update_weights(evaluation)
            self._checkpoint()

    def _count(self, evaluation: Evaluation) -> None:
        self._account(evaluation)
        self._progress.evaluated(evaluation)

    def _account(self, evaluation: Evaluation) -> None:
        """The time an evaluation took, and why it failed."""
        for node, seconds in evaluation.seconds.items():
            self._seconds_by_node[node] = self._seconds_by_node.get(node, 0.0) + seconds
        if evaluation.failed and not evaluation.cached:
            log.info("failed: %s: %s", dict(evaluation.values), evaluation.failed)
            if evaluation.raised is not None:
                log.error("%s", evaluation.raised.traceback)
            self._observers.tell(
                "tacos_candidate_failed", candidate=evaluation.values, reason=evaluation.failed
            )

    def _record(self, number: int, search: Search, evaluations: Sequence[Evaluation], seconds: float) -> None:
        """Write a generation's line."""
        best = search.best
        line = {
            "generation": number,
            "seconds": round(seconds, 3),
            "frames": sum(evaluation.images for evaluation in evaluations),
            "candidates": [_line(evaluation) for evaluation in evaluations],
            "best": best and {"camera": best.values, "fitness": best.fitness, "scores": best.scores},
        }
        self.results.append_line("generations.jsonl", line)

    def _judge(self) -> None:
        """Score every camera on the test scenes, and take sample frames there."""
        cameras = {search.name: search for search in self.searches if search.best is not None}
        test = self.plan.recipe.test
        if test is None or not cameras:
            return
        missing = {name: search for name, search in cameras.items() if name not in self._test}
        self._progress.phase("Testing on unseen scenes", len(missing))
        episodes = tuple(EpisodeSpec(test.seed, ("test", i), test.frames) for i in range(test.episodes))
        jobs = [ScoreJob(s.best.values, episodes, s.states) for s in missing.values() if s.best is not None]
        scored = score_sharded(jobs, self.plan.fitness, self._executor, self._evaluate)
        for name, evaluation in zip(missing, scored, strict=True):
            self._count(evaluation)
            self._test[name] = evaluation
        if not self.plan.graph.of_kind("sensor"):
            return
        shots = [
            SampleJob(s.best.values, episodes[0], SAMPLES_AT) for s in cameras.values() if s.best is not None
        ]
        for name, batches in zip(cameras, self._executor.map(self._evaluate, shots), strict=True):
            self._samples[name] = [
                self.results.write_sample(f"{name}_{i}", _picture(batch)) for i, batch in enumerate(batches)
            ]

    # checkpoint and result --------------------------------------------------------------------------------

    @property
    def seconds(self) -> float:
        """Wall time of the study, earlier parts of a resumed run included [s]."""
        return self._seconds_before + time.monotonic() - self._started

    def _checkpoint(self) -> None:
        weights: dict[str, str] = {}
        for search in self.searches:
            for task, state in search.states.items():
                name = f"{search.name}.{task}.{search.rounds}"
                weights[f"{search.name}.{task}"] = name
                if not (self.results.folder / "weights" / f"{name}.safetensors").exists():
                    self.results.write_state(name, state)
        self.results.write_checkpoint(
            {
                "searches": {search.name: search.state() for search in self.searches},
                "seconds": self.seconds,
                "seconds_by_node": self._seconds_by_node,
                "weights": weights,
            }
        )
        self.results.keep_weights(weights.values())

    def restore(self, checkpoint: Mapping[str, Any] | None) -> None:
        """Go on from a checkpoint; from the start when there is none."""
        if checkpoint is None:
            self.results.write_lines("generations.jsonl", [])
            return
        self._seconds_before = checkpoint["seconds"]
        self._seconds_by_node = dict(checkpoint["seconds_by_node"])
        for search in self.searches:
            states: dict[str, State] = {
                task: self.results.read_state(checkpoint["weights"][f"{search.name}.{task}"])
                for task in search.states
            }
            search.restore(checkpoint["searches"][search.name], states)
        done = self.searches[0].generation
        self.results.write_lines("generations.jsonl", self.results.read_lines("generations.jsonl")[:done])

    def finish(self) -> dict[str, Any]:
        """Write ``result.json``; returns what stands in it."""
        designed = self.searches[0]
        result = {
            "tacos": __version__,
            "name": self.plan.recipe.name,
            "seed": self.plan.recipe.seed,
            "stopped": self.broken_off or designed.stopped,
            "evaluations": sum(search.evaluations for search in self.searches) + len(self._test),
            "frames_rendered": sum(search.images for search in self.searches)
            + sum(evaluation.images for evaluation in self._test.values()),
            "seconds": round(self.seconds, 3),
            "best": designed.best and _best(designed.best),
            "test": {
                name: {**evaluation.scores, "fitness": evaluation.fitness}
                for name, evaluation in self._test.items()
            },
            "cameras": {s.name: self._camera(s) for s in self.searches if s.best is not None},
            "derived_units": dict(self.plan.rig.cls.derived_quantities),
            "design_space": self.plan.space.as_data(),
            "fitness": [{"score": term.score, "weight": term.weight} for term in self.plan.recipe.fitness],
            "lower_is_better": sorted(
                f"{name}.{score}"
                for name, node in self.plan.nodes.items()
                for score in getattr(node.cls, "lower_is_better", ())
            ),
            "seconds_by_node": {name: round(s, 3) for name, s in self._seconds_by_node.items()},
            "environment": self._environment,
            "notes": [*self.plan.recipe.notes, *self._automatic_notes()],
            "samples": self._samples,
            "command": self._command,
        }
        self.results.write_json("result.json", result)
        self._observers.tell("tacos_study_finished", result=result)
        return result

    def _camera(self, search: Search) -> dict[str, Any]:
        assert search.best is not None
        titles = {camera.name: camera.title for camera in self.plan.cameras}
        test = self._test.get(search.name)
        return {
            "title": titles.get(search.name, "Designed"),
            "camera": search.best.values,
            "derived": search.best.derived,
            "terms": test.terms if test else {},
            "episodes": list(test.episodes) if test else [],
            "spread": standard_errors(test.episodes) if test else {},
            "evaluations": search.evaluations,
            **({"scenarios": test.scenarios} if test and test.scenarios else {}),
            "free": list(search.space.names) if search.space else [],
        }

    def _automatic_notes(self) -> Iterator[str]:
        binning = getattr(self.plan.rig.config, "binning", 1)
        if binning != 1:
            yield (
                f"Pixel counts are scaled down: each simulated pixel averages {binning:g} x {binning:g} "
                f"photosites, and its noise is that of the average. Resolutions compare with one another, "
                f"but scores are not those of the full pixel counts."
            )
        if trainings := max(search.trained_best for search in self.searches):
            yield f"Before the test, the trainable tasks were trained {trainings} times more on each camera."
        for variable in self.plan.space.as_data():
            if left_out := variable.get("left_out"):
                yield (
                    f"Not to choose from, as their {', '.join(variable['columns'])} are not all known: "
                    f"{', '.join(left_out)} ({variable['catalog']})."
                )
        yield from self._notes_on_constraints
        if (best := self.searches[0].best) is not None:
            yield from notes_on_camera(self.plan, best.values)
        failed = [search.name for search in self.searches if search.best is None and search.generation]
        for name in (name for name in failed if name not in self._inadmissible):
            yield f"No candidate of {name!r} could be evaluated; see generations.jsonl and log.txt for why."


def _best(evaluation: Evaluation) -> dict[str, Any]:
    data = as_data(evaluation)
    return {
        "camera": data["values"],
        "derived": data["derived"],
        "fitness": data["fitness"],
        "scores": data["scores"],
        "terms": data["terms"],
        **({"scenarios": data["scenarios"]} if data["scenarios"] else {}),
    }


def _line(evaluation: Evaluation) -> dict[str, Any]:
    """A candidate's part of a line of ``generations.jsonl``."""
    return {
        "key": content_key(evaluation.values),
        "camera": evaluation.values,
        "derived": evaluation.derived,
        "fitness": evaluation.fitness,
        "scores": evaluation.scores,
        "terms": evaluation.terms,
        "failed": evaluation.failed,
        "cached": evaluation.cached,
        "dropped": evaluation.dropped,
        **({"scenarios": evaluation.scenarios} if evaluation.scenarios else {}),
    }


def _picture(batch: FrameBatch) -> NDArray[np.uint8]:
    """The first camera's first frame, (H, W, 3), encoded for a display."""
    return display_image(batch.images[0][0], batch.black_level_dn, batch.white_level_dn)
