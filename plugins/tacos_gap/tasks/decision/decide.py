"""Ranks the cameras of a study in the simulation as it was, and with the causes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tacos_framework import Evaluation, Executor, Fault, Plugins, Progress, UserError
from tacos_framework.plan import Plan
from tacos_framework.simulation import Evaluator, ScoreJob
from tacos_framework.store import DESIGNED
from tacos_framework.study import Search, UnseenTest, rescore_finalists
from tacos_gap.tasks.decision.choice import choice, sentence
from tacos_gap.tasks.decision.ranked import RankedCameras, ranked
from tacos_gap.tasks.recipe_tasks import frozen_plan

CONFIDENCE = 0.95
"""Of intervals where the study has no test to say."""

PROBE = ({"use": "effect.exposure-error", "scale": 0.9},)
"""An effect that any simulation of images can have: where it cannot be added, no cause can."""


@dataclass(frozen=True)
class Question:
    """A study whose decision is asked for."""

    study: str
    change: Mapping[str, Any]
    evaluations: int
    design: int

    def plan(self, plugins: Plugins, effects: Sequence[Mapping[str, Any]] = ()) -> Plan:
        """The checked study; tasks that learn keep the weights they were given.

        Raises UserError when it is no study, compares no cameras, or a task of it was never trained.
        """
        plan = frozen_plan(self.study, self.change, plugins, effects)
        if not plan.cameras and not self.design:
            raise UserError(
                Fault("study", f"{self.study} compares no cameras", "compare: {cameras: [...]}, or design")
            )
        return plan

    def check(self, plugins: Plugins) -> None:
        """Plan it without and with effects. Raises UserError as `plan` does."""
        self.plan(plugins)
        self.plan(plugins, PROBE)


def decide(
    question: Question,
    effects: Sequence[Mapping[str, Any]],
    plugins: Plugins,
    executor: Executor,
    progress: Progress,
) -> dict[str, Any]:
    """Fitness of each camera on the same unseen scenes, without and with the effects.

    What a camera leaves free is optimised anew in either simulator, as a user would. Scenes are added as the
    study's test says, until it is decided whether a camera beats the one that was best before.
    """
    plan = question.plan(plugins)
    without, own = _ranked(plan, question, plugins, executor, progress, "Ranking cameras without it", "")
    with_effects = question.plan(plugins, effects)
    best = without.order[0]
    after, designed = _ranked(
        with_effects, question, plugins, executor, progress, "Ranking cameras with it", best
    )
    found = choice(without, after)
    confidence = plan.recipe.test.confidence if plan.recipe.test else CONFIDENCE
    return {
        "study": question.study,
        "frozen": list(plan.trainable),
        "confidence": confidence,
        "cameras": [
            {
                "camera": camera,
                "without": without.evaluations[camera].fitness,
                "with": after.evaluations[camera].fitness,
                "ci": {"without": without.intervals.get(camera), "with": after.intervals.get(camera)},
                "chance_best": {
                    "without": without.chance_best.get(camera),
                    "with": after.chance_best.get(camera),
                },
            }
            for camera in without.order
        ],
        "ranking": {"without": without.order, "with": after.order},
        "ranking_changes": after.order != without.order,
        "best_changes": after.order[0] != without.order[0],
        "choice": found.as_data(),
        DESIGNED: {"without": own, "with": designed} if question.design else {},
        "sentence": sentence(without, after, found, confidence),
    }


def _ranked(
    plan: Plan,
    question: Question,
    plugins: Plugins,
    executor: Executor,
    progress: Progress,
    title: str,
    reference: str,
) -> tuple[RankedCameras, dict[str, Any]]:
    """Every camera at its best, on the test scenes, and the values of the designed one.

    Without test scenes they are ranked by those of the design. By default the most promising camera is the
    one that others are compared with.
    """
    evaluate = Evaluator(plan, plugins)
    states = evaluate.simulation.initial_states() if plan.trainable else {}
    searches = []
    for camera in plan.cameras:
        free = plan.free_of(camera)
        space = free if free.variables else None
        searches.append(
            Search(camera.name, plan, space, dict(camera.fixes), question.evaluations, dict(states))
        )
    if question.design:
        searches.append(Search(DESIGNED, plan, plan.space, {}, question.design, dict(states)))
    progress.phase(title, None)
    for search in searches:
        while not search.stopped:
            search.step(executor, evaluate, progress.evaluated)
        progress.step(search.name)
    rescore_finalists(searches, executor, evaluate, lambda count: None, progress.evaluated)
    found = {search.name: search.best for search in searches if search.best is not None}
    lost = {s.name: Evaluation({}, failed="no candidate could be scored") for s in searches if s.best is None}
    designed = dict(found[DESIGNED].values) if DESIGNED in found else {}
    test, seed = plan.recipe.test, plan.recipe.seed
    if test is None:
        return ranked({**lost, **found}, plan.fitness, error=1 - CONFIDENCE, seed=seed), designed
    best = max(found, key=lambda name: found[name].fitness or float("-inf"), default="")
    unseen = UnseenTest(test, plan.fitness, reference if reference in found else best)
    jobs = {name: ScoreJob(each.values, (), states) for name, each in found.items()}
    unseen.run(jobs, executor, evaluate, lambda count: None, progress.evaluated)
    progress.step("unseen scenes")
    return (
        ranked(
            {**lost, **unseen.on_common_scenes},
            plan.fitness,
            error=1 - test.confidence,
            seed=seed,
            comparisons=unseen.comparisons,
            reference=unseen.designed,
        ),
        designed,
    )
