"""The study: design a camera, search what off-the-shelf cameras leave free, test all on unseen scenes."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, repeat
from typing import Any

from tacos_framework.camera.clipping import Exposed
from tacos_framework.contracts import Executor
from tacos_framework.environment import describe_environment
from tacos_framework.plan import Plan
from tacos_framework.plugins import Plugins
from tacos_framework.simulation import EpisodeSpec, Evaluation, Evaluator, ScoreJob
from tacos_framework.store import DESIGNED, RESULT, Results
from tacos_framework.store.manifest import Manifest
from tacos_framework.study.account import Account
from tacos_framework.study.analysis import make_record
from tacos_framework.study.checkpoints import Checkpoints
from tacos_framework.study.degenerate import degenerate
from tacos_framework.study.extension import budget_of
from tacos_framework.study.failure_policy import KeepsFailing
from tacos_framework.study.finalists import rescore_finalists
from tacos_framework.study.journal import Journal, JournaledExecutor
from tacos_framework.study.kept_evaluation import as_data, evaluation_from
from tacos_framework.study.outcome import Outcome
from tacos_framework.study.progress import Progress
from tacos_framework.study.records import generation_record
from tacos_framework.study.samples import write_samples
from tacos_framework.study.search import Search
from tacos_framework.study.shards import score_sharded
from tacos_framework.study.unseen_test import UnseenTest
from tacos_framework.study.worlds_ahead import BuildingAhead

log = logging.getLogger(__name__)

BROKEN_OFF = "interrupted by the user"
"""Why a study stopped that was broken off with Ctrl-C, as its result says."""

GENERATIONS, PRODUCTS = "generations.jsonl", "products.jsonl"
"""Files with a line for each generation of the design, and of the searches of what products leave free."""

DEFECT = "stopped by a defect"
"""Begins why a study stopped whose candidates kept failing by the same defect of a component."""


class Study:
    """One run of a recipe; see `run_study`."""

    def __init__(
        self,
        plan: Plan,
        plugins: Plugins,
        results: Results,
        executor: Executor,
        progress: Progress,
        manifest: Manifest,
        command: str = "",
    ):
        self.plan = plan
        self.results = results
        self.broken_off: str | None = None
        self._observers = plugins.offers.observers()
        self._manifest = manifest
        self._progress = progress
        self._command = command
        self._evaluate = Evaluator(plan, plugins)
        self._seconds_before = 0.0
        self._started = time.monotonic()
        self._account = Account(self._observers)
        test = plan.recipe.test
        self._test = UnseenTest(test, plan.fitness, DESIGNED) if test else None
        self._analysis: dict[str, Any] = {}
        self._analysis_notes: list[str] = []
        self._scored_again: list[Evaluation] = []
        self._samples: dict[str, list[str]] = {}
        self._exposed: dict[str, Exposed] = {}
        journal = Journal(results, lambda: self.seconds)
        self._executor = JournaledExecutor(executor, journal)
        keeps_worlds = plugins.offers.episode_store() is not None
        certain = self._test.episodes(0, self._test.looks[0]) if self._test and keeps_worlds else ()
        self._builds_ahead = BuildingAhead(self._executor, certain)
        self._environment = describe_environment(self._executor.workers, plugins.offers.findings())
        self.searches = list(self._make_searches())
        self._checkpoints = Checkpoints(results, journal, self._line_files)

    def _make_searches(self) -> Iterator[Search]:
        states = self._evaluate.simulation.initial_states() if self.plan.trainable else {}
        yield (design := Search(DESIGNED, self.plan, self.plan.space, {}, None, dict(states)))
        budget = self.plan.recipe.compare.evaluations if self.plan.recipe.compare else None
        for camera in self.plan.cameras:
            free = self.plan.free_of(camera)
            space = free if free.variables else None
            yield Search(
                camera.name, self.plan, space, dict(camera.fixes), budget, dict(states), design=design
            )

    # running ----------------------------------------------------------------------------------------------

    def run(self) -> None:
        """Search, then test; each step checkpointed."""
        log.info("%s", self._command or self.plan.recipe.name)
        for name, value in self._environment["findings"].items():
            log.info("%s: %s", name, value)
        self._observers.tell("tacos_study_started", recipe=self.plan.recipe, out=self.results.folder)
        for search in self.searches:
            self._search(search)
        self._rescore_finalists()
        self._train_best()
        self._test_on_unseen_scenes()
        self._analyse()
        self._checkpoint(now=True)

    def _search(self, search: Search) -> None:
        if search.stopped:
            return
        title = "Designing" if search.name == DESIGNED else f"Fitting {search.name}"
        self._progress.phase(title, search.expected_candidates())
        while not search.stopped:
            began = time.monotonic()
            number = search.generation
            try:
                evaluations = search.step(self._builds_ahead, self._evaluate, self._count)
            except KeepsFailing as error:  # shown; --resume asks for this generation again
                self._record(number, search, error.evaluations, time.monotonic() - began)
                raise
            if evaluations:
                self._record(number, search, evaluations, time.monotonic() - began)
            if search.name == DESIGNED and evaluations:
                best = search.best
                self._observers.tell(
                    "tacos_generation_finished", generation=number, evaluated=evaluations, best=best
                )
                log.info("generation %d: best %s", number, best and best.fitness)
            self._progress.best(search.best)
            self._checkpoint()
        self._checkpoint(now=True)
        log.info("%s: %s; best fitness %s", search.name, search.stopped, search.best and search.best.fitness)

    def _rescore_finalists(self) -> None:
        """Score the most promising of each search once more, all at the same time."""
        if all(search.finalists_rescored for search in self.searches):
            return

        def on_counted(count: int) -> None:
            self._progress.phase("Scoring finalists", count)

        running = (self._executor, self._evaluate, on_counted, self._count)
        rescore_finalists(self.searches, *running, tested=self._test is not None)
        self._checkpoint(now=True)
        for search in self.searches:
            if search.finalists:
                log.info("%s: best of its finalists %s", search.name, search.best and search.best.fitness)

    def _train_best(self) -> None:
        """Train each camera's network further on that camera; the cameras at the same time."""
        trainings = self.plan.recipe.study.train_best
        if any(search.next_training_on_best() for search in self.searches):
            self._progress.phase("Training on the best", trainings * len(self.searches))
        while pending := [(s, job) for s in self.searches if (job := s.next_training_on_best()) is not None]:
            trained = self._executor.map(self._evaluate, [job for _, job in pending])
            for (search, _), evaluation in zip(pending, trained, strict=True):
                self._account.add(evaluation)
                self._progress.step()
                search.update_weights(evaluation)
            self._checkpoint()

    def _count(self, evaluation: Evaluation) -> None:
        self._account.add(evaluation)
        self._progress.evaluated(evaluation)

    def _record(self, number: int, search: Search, evaluations: Sequence[Evaluation], seconds: float) -> None:
        """Write a generation's line; those of products into a file of their own."""
        line = generation_record(number, evaluations, search.best, seconds)
        if search.name == DESIGNED:
            self.results.append_line(GENERATIONS, line)
        else:
            self.results.append_line(PRODUCTS, {"product": search.name, **line})

    def _test_on_unseen_scenes(self) -> None:
        """Score every camera on the test scenes, and take sample frames there."""
        jobs = {s.name: ScoreJob(s.best.values, (), s.states) for s in self.searches if s.best is not None}
        if self._test is None or not jobs:
            return

        titles = chain(["Testing on unseen scenes"], repeat("Testing on more unseen scenes"))

        def on_look(count: int) -> None:
            self._checkpoint()
            self._progress.phase(next(titles), count)

        self._test.run(jobs, self._executor, self._evaluate, on_look, self._count)
        self._checkpoint()
        if self.plan.graph.of_kind("sensor"):
            seen = {name: job.values for name, job in jobs.items()}
            episode = self._test.episodes(0, 1)[0]
            self._samples, self._exposed = write_samples(
                seen, episode, self._executor, self._evaluate, self.results
            )

    def _analyse(self) -> None:
        """Let plugins say what follows from all that was scored."""
        self._progress.phase("Analysing", None)
        lines = [line for name in self._line_files for line in self.results.read_lines(name)]
        record = make_record(
            self.plan,
            self.searches,
            lines,
            self._test,
            self._outcome().failed(),
            self._score_again,
            degenerate(self.searches[0], self.plan.recipe),
        )
        self._analysis, self._analysis_notes = self._observers.ask("tacos_analyse_study", record=record)

    def _score_again(self, cameras: Sequence[Mapping[str, Any]], episodes: int) -> list[Evaluation]:
        """Score cameras that an analysis asks for, all on the same fresh episodes."""
        seed, states = self.plan.recipe.seed, self.searches[0].states
        specs = tuple(EpisodeSpec(seed, ("analysis", i)) for i in range(episodes))
        jobs = [ScoreJob(dict(values), specs, states) for values in cameras]
        found = list(score_sharded(jobs, self._executor, self._evaluate)) if jobs else []
        for evaluation in found:
            self._count(evaluation)
        self._scored_again += found
        return found

    # checkpoint and result --------------------------------------------------------------------------------

    @property
    def seconds(self) -> float:
        """Wall time of the study, earlier parts of a resumed run included [s]."""
        return self._seconds_before + time.monotonic() - self._started

    @property
    def _line_files(self) -> tuple[str, ...]:
        """The files that searches write a line to for each generation."""
        return (GENERATIONS, PRODUCTS) if len(self.searches) > 1 else (GENERATIONS,)

    def _checkpoint(self, *, now: bool = False) -> None:
        self._checkpoints.write(self.searches, self._rest, now=now)

    def _rest(self) -> dict[str, Any]:
        """Content of a checkpoint beside the searches."""
        return {
            "budget": budget_of(self.plan.optimizer),
            "seconds": self.seconds,
            "seconds_by_node": self._account.seconds_by_node,
            "test": {name: as_data(found) for name, found in self._test.evaluations.items()}
            if self._test
            else {},
        }

    def restore(self, checkpoint: Mapping[str, Any] | None) -> None:
        """Go on from a checkpoint; from the start when there is none."""
        self._seconds_before = self._checkpoints.restore(checkpoint, self.searches)
        if checkpoint is None:
            return
        self._seconds_before = max(self._seconds_before, checkpoint["seconds"])
        self._account.seconds_by_node = dict(checkpoint["seconds_by_node"])
        if self._test:
            self._test.evaluations = {n: evaluation_from(found) for n, found in checkpoint["test"].items()}
        if checkpoint["budget"] != budget_of(self.plan.optimizer):
            self._extend(checkpoint)

    def _extend(self, checkpoint: Mapping[str, Any]) -> None:
        """Search on with the larger budget; whatever came after the searches is done anew."""
        for search in self.searches:
            trained = search.trained_best > 0
            if not search.reopen():
                continue
            if trained:
                search.states = self._checkpoints.states_at_end(checkpoint, search)
            if self._test:
                self._test.evaluations = {}

    def finish(self) -> dict[str, Any]:
        """Write ``result.json``; returns what stands in it."""
        outcome = self._outcome()
        accepted = [change for changes in self._manifest.accepted for change in changes]
        result = {
            **outcome.as_data(),
            "seconds": round(self.seconds, 3),
            "seconds_by_node": {name: round(s, 3) for name, s in self._account.seconds_by_node.items()},
            "environment": self._environment,
            "notes": [
                *self.plan.recipe.quoted_notes,
                *outcome.notes(),
                *(f"The study went on although, since it began, {change}." for change in accepted),
                *self._analysis_notes,
                *(f"Sample frames of {n}: {each.doubt}." for n, each in self._exposed.items() if each.doubt),
            ],
            "samples": self._samples,
            "exposed": {name: each._asdict() for name, each in self._exposed.items()},
            "command": self._command,
        }
        if taken := sorted(set(result) & set(self._analysis)):
            result["notes"].append(
                f"Of an analysis, {', '.join(taken)} is left out: the study says it itself."
            )
        result = {**self._analysis, **result}
        self.results.write_json(RESULT, result)
        self._observers.tell("tacos_study_finished", result=result)
        return result

    def _outcome(self) -> Outcome:
        return Outcome(self.plan, self.searches, self._test, self._scored_again, self.broken_off)
