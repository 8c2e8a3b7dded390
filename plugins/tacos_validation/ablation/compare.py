"""A study of some cameras, as it stands and with steps of its simulation left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tacos_framework import Executor, Plugins, Progress, generator
from tacos_framework.plan import Plan, make_plan
from tacos_framework.store import Results
from tacos_validation.ablation.order import Order, is_worse
from tacos_validation.ablation.pages import page, summary, table_csv
from tacos_validation.ablation.settings import AblationConfig
from tacos_validation.harness import FaultsTogether, leave, study_recipe
from tacos_validation.rank_agreement.agreement import agreement, places
from tacos_validation.rank_agreement.cameras import cameras_of
from tacos_validation.rank_agreement.scored import Judge, scores_of

WHOLE = "as it stands"
"""Name of the study that leaves nothing out."""


class Ablation:
    """Shows what each step of a simulation changes in the ranking of cameras.

    All variants see the same worlds, paths and draws. A camera equals the best where the interval of the
    difference of their fitness over the scenes, by Student's t, holds 0. Cameras without a place in some
    variant are left out of all. A broken run goes on with ``--resume``: scores are kept as they come.
    """

    Config = AblationConfig

    def __init__(self, config: AblationConfig) -> None:
        self.config = config

    def check(self, *, plugins: Plugins) -> None:
        cameras_of(self.config.cameras, self._plans(plugins)[WHOLE])

    def run(
        self, *, out: Path, seed: int, plugins: Plugins, executor: Executor, progress: Progress, resume: bool
    ) -> Mapping[str, Any]:
        plans = self._plans(plugins)
        cameras = cameras_of(self.config.cameras, plans[WHOLE])
        scenes = self.config.scenes or plans[WHOLE].recipe.study.episodes
        values = {camera.name: camera.values for camera in cameras}
        results, judges = Results(out), {}
        for name, plan in plans.items():
            progress.phase(name, len(cameras) * scenes)
            rows = scores_of(plan, cameras, scenes, plugins, executor, results, progress.step)
            judges[name] = Judge(values, rows, plan.fitness)
        whole = range(scenes)
        ranked = [name for name in values if all(judge(name, whole) is not None for judge in judges.values())]
        orders = [self._order(name, judges, ranked, scenes, seed) for name in plans]
        left_out = sorted(values.keys() - set(ranked))
        data = {
            "study": self.config.study,
            "scenes": scenes,
            "orders": [asdict(order) for order in orders],
            "left_out": left_out,
        }
        return leave(
            out, page(self.config, orders, left_out, scenes), data, summary(orders), table=table_csv(orders)
        )

    def _plans(self, plugins: Plugins) -> dict[str, Plan]:
        plans, faults = {}, FaultsTogether()
        for name, keys in {WHOLE: {}, **self.config.without}.items():
            with faults.of(f"without.{name}" if keys else ""):
                plans[name] = make_plan(
                    study_recipe(self.config.study, {**self.config.change, **keys}), plugins
                )
        faults.refuse()
        return plans

    def _order(
        self, name: str, judges: Mapping[str, Judge], ranked: Sequence[str], scenes: int, seed: int
    ) -> Order:
        judge = judges[name]
        fitness, before = (
            {each: float(one(each, range(scenes)) or 0.0) for each in ranked}
            for one in (judge, judges[WHOLE])
        )
        best = max(ranked, key=lambda each: fitness[each])
        own, reference = places(fitness), places(before)
        farthest = max(ranked, key=lambda each: abs(own[each] - reference[each]))
        found = agreement(
            ranked,
            judge,
            judges[WHOLE],
            scenes,
            resamples=self.config.resamples,
            confidence=self.config.confidence,
            rng=generator(seed, "ablation", name),
        )
        return Order(
            name,
            found,
            best,
            tuple(each for each in ranked if not is_worse(each, best, judge, scenes, self.config.confidence)),
            abs(own[farthest] - reference[farthest]),
            farthest,
            fitness,
        )
