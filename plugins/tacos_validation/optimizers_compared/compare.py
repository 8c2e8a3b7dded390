"""Several optimizers on one design problem: images rendered, judged on scenes none of them has seen."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from threading import Lock
from typing import Any

from tacos_framework import Executor, Fault, Plugins, Progress, UserError
from tacos_framework.simulation import EpisodeSpec, Evaluator
from tacos_framework.store import Results
from tacos_framework.study import KeepsFailing, Search
from tacos_validation.harness import leave
from tacos_validation.optimizers_compared.contest import BUDGET_SPENT, FromTable, Run
from tacos_validation.optimizers_compared.outcome import Comparison, curves_csv, standings_csv
from tacos_validation.optimizers_compared.pages import page, summary
from tacos_validation.optimizers_compared.problem import Contenders, contenders_of, held_out_scenes
from tacos_validation.optimizers_compared.reference import admissible, climb
from tacos_validation.optimizers_compared.settings import CompareOptimizersConfig
from tacos_validation.optimizers_compared.standings import JudgedRun, quartiles, standings
from tacos_validation.optimizers_compared.together import FilledTogether, together
from tacos_validation.score_table import ScoreTable


class CompareOptimizers:
    """Runs optimizers side by side, each as often as there are seeds, until their images are spent.

    All search the same problem on a grid of candidates and on scenes that never change, so that everything
    they can ask for stands in one table, which is filled as they ask (a tabular benchmark). Each run goes as
    it would in a study, and is charged the images it would have had rendered there: what it has had before
    costs nothing, nor does what breaks a constraint; a candidate scored on few scenes costs those; what other
    runs have rendered is charged all the same. At checkpoints each run is asked what it recommends, and that
    is judged on scenes that no run sees, against the best camera that a search on those very scenes finds.

    A broken run goes on with ``--resume``: the table is kept as it grows, and the optimizers search again
    in it.
    """

    Config = CompareOptimizersConfig

    def __init__(self, config: CompareOptimizersConfig) -> None:
        self.config = config

    def run(
        self, *, out: Path, seed: int, plugins: Plugins, executor: Executor, progress: Progress, resume: bool
    ) -> Mapping[str, Any]:
        contenders = contenders_of(self.config, plugins)
        plan = contenders.problem
        coarse = admissible(plan, self.config.reference)
        evaluate = Evaluator(plan.recipe, plugins)
        table = ScoreTable(plan, evaluate, executor, Results(out))
        runs = self._search(contenders, table, evaluate, seed, progress)
        scenes = held_out_scenes(self.config.held_out)
        progress.phase("Looking for the best camera on the held-out scenes", None)
        best = climb(plan, self.config.reference, coarse, table, scenes, progress.step)
        recommended = [stand.values for run in runs for stand in _stands(run) if stand.values is not None]
        progress.phase("Judging what was recommended", None)
        table.fill([(values, spec) for values in recommended for spec in scenes], progress.step)
        comparison = self._judge(runs, table, scenes, [best, *recommended], contenders.notes)
        tables = {"curves": curves_csv(comparison), "standings": standings_csv(comparison)}
        return leave(out, page(comparison), comparison.as_data(), summary(comparison), **tables)

    def _search(
        self, contenders: Contenders, table: ScoreTable, evaluate: Evaluator, seed: int, progress: Progress
    ) -> list[Run]:
        lock = Lock()

        def say(note: str) -> None:
            with lock:  # runs go in threads
                progress.step(note)

        runs = [
            Run(
                name,
                number,
                Search(f"{name}, run {seed}-{number}", plan, plan.space, fixed={}, budget=None),
                self.config.checkpoints_of(name),
                self.config.target.rounds,
                say,
            )
            for number in range(self.config.seeds)
            for name, plan in contenders.plans.items()
        ]
        progress.phase("Searching", sum(len(run.checkpoints) for run in runs))
        filled = FilledTogether(table, len(runs))

        def go(run: Run) -> None:
            try:
                run.go(FromTable(table, filled.fill), evaluate)
            except KeepsFailing as error:
                raise UserError(Fault("problem", f"{run.optimizer_name}: {error}")) from error

        together(runs, go, filled)
        return runs

    def _judge(
        self,
        runs: Sequence[Run],
        table: ScoreTable,
        scenes: Sequence[EpisodeSpec],
        known: Sequence[Mapping[str, Any]],
        notes: Sequence[str],
    ) -> Comparison:
        def fitness(values: Mapping[str, Any] | None) -> float:
            found = None if values is None else table.evaluation(values, scenes).fitness
            return -math.inf if found is None else found

        best = max(known, key=fitness)
        judged: dict[str, list[JudgedRun]] = {}
        for run in runs:
            images = {stand.checkpoint: stand.images for stand in run.stands}
            at = {stand.checkpoint: fitness(stand.values) for stand in run.stands}
            judged.setdefault(run.optimizer_name, []).append(
                JudgedRun(run.optimizer_name, run.seed, images, at)
            )
        asked = self.config.target
        own = [run.after_rounds or run.stands[-1] for run in runs if run.optimizer_name == asked.optimizer]
        target = quartiles([fitness(stand.values) for stand in own]).median
        target_images = quartiles([stand.images for stand in own]).median
        against = {
            name: target_images
            if name == asked.optimizer
            else quartiles([run.images_to(target) for run in judged[name]]).median
            for name in self.config.against
            if name in judged
        }
        found = standings(
            judged,
            target=target,
            best_known=fitness(best),
            against=against,
            budgets={name: self.config.checkpoints_of(name)[-1] for name in judged},
            thought_ms={name: _thought_ms([r for r in runs if r.optimizer_name == name]) for name in judged},
        )
        return Comparison(
            problem=self.config.problem,
            target_of=f"{asked.optimizer} after {asked.rounds} round{'s' if asked.rounds > 1 else ''}",
            target=target,
            target_images=target_images,
            best_known=fitness(best),
            best_camera=best,
            held_out=len(scenes),
            runs=judged,
            standings=found,
            rendered=table.images,
            notes=(
                *notes,
                *_early_stops(runs, asked.optimizer, asked.rounds),
                *self._short_of(target_images),
            ),
        )

    def _short_of(self, target_images: float) -> list[str]:
        last = self.config.checkpoints[-1]
        if target_images <= last:
            return []
        return [f"The target took {target_images:.0f} images; the last checkpoint of most runs is {last}."]


def _stands(run: Run) -> list[Any]:
    return [*run.stands, *([run.after_rounds] if run.after_rounds else [])]


def _thought_ms(runs: Sequence[Run]) -> float:
    return 1e3 * sum(run.thought_seconds for run in runs) / max(1, sum(run.candidates for run in runs))


def _early_stops(runs: Sequence[Run], target: str, rounds: int) -> list[str]:
    early = sorted({f"{run.optimizer_name}: {run.stopped}" for run in runs if run.stopped != BUDGET_SPENT})
    notes = [f"Not all runs spent their budget. {each}." for each in early]
    short = sum(run.optimizer_name == target and run.after_rounds is None for run in runs)
    if short:
        notes.append(
            f"{short} runs of {target} ended before round {rounds}: what they recommended last stands for it."
        )
    return notes
