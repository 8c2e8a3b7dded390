"""The tasks that are scored on captures: those of a recipe, with weights that stay as they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from tacos_framework import (
    Fault,
    Plugins,
    Recipe,
    State,
    TaskBase,
    TrainableBase,
    UserError,
    calling,
    generator,
    learns,
    load_recipe,
    optional,
)
from tacos_framework.plan import ConfiguredComponent, Plan, make_plan

DEFAULT = "task.orb-features"
DEFAULT_NODE = "features"
"""What a recipe usually calls it: scores are named ``features.inliers``."""


@dataclass(frozen=True)
class RecipeTask:
    node: str
    part: ConfiguredComponent
    state: State | None = field(default=None, compare=False, repr=False)
    """What it has learnt; None for a task that does not learn."""
    why_not: str = ""  # why it cannot be scored on captures at all, in a sentence; empty where it can
    counted: tuple[str, ...] = ()  # those of its scores that the recipe's fitness counts

    @property
    def title(self) -> str:
        return f"{self.node} ({self.part.use})"

    def begin(self) -> Any:
        with self.part.calling(f"begin in node {self.node!r}"):
            return self.part.instance.begin(state=self.state)

    def lower_is_better(self, score: str) -> bool:
        """True if a score is an error."""
        return score in optional(self.part.cls, TaskBase, "lower_is_better")


def default_tasks(plugins: Plugins) -> tuple[RecipeTask, ...]:
    """ORB features, where they are installed: what the paper checks its simulator by."""
    if not any(r.component.use == DEFAULT for r in plugins):
        return ()
    cls = plugins.resolve(DEFAULT, "task")
    with calling(DEFAULT, plugins.distribution_of(DEFAULT), "as it is built"):
        part = ConfiguredComponent(DEFAULT, cls, cls.Config(), plugins.distribution_of(DEFAULT))
    return (RecipeTask(DEFAULT_NODE, part),)


def tasks_of(plan: Plan) -> tuple[RecipeTask, ...]:
    """Every task of a study; first those whose scores its fitness counts."""
    counted: dict[str, list[str]] = {}
    for term in plan.fitness.terms:
        node, _, score = term.score.partition(".")
        counted.setdefault(node, []).append(score)
    names = sorted(plan.graph.of_kind("task"), key=lambda name: name not in counted)
    return tuple(_task_of(plan, name, tuple(counted.get(name, ()))) for name in names)


def _task_of(plan: Plan, name: str, counted: tuple[str, ...]) -> RecipeTask:
    part = plan.nodes[name]
    if len(plan.graph.nodes[name].sources) != 1:
        why = "it has several ports, and a capture is one stream of frames"
        return RecipeTask(name, part, why_not=why, counted=counted)
    state: State | None = None
    if learns(part.cls):
        untrained = optional(part.instance, TrainableBase, "untrained")
        if callable(untrained) and (reason := untrained()):
            return RecipeTask(
                name, part, why_not=f"its weights were never trained: {reason}", counted=counted
            )
        with part.calling(f"initial_state in node {name!r}"):
            state = part.instance.initial_state(rng=generator(plan.recipe.seed, "states", name))
    return RecipeTask(name, part, state, counted=counted)


def frozen_plan(
    study: str,
    change: Mapping[str, Any],
    plugins: Plugins,
    effects: Sequence[Mapping[str, Any]] = (),
    where: str = "study",
) -> Plan:
    """A study with the weights of its tasks as they were trained before.

    Training goes by frames of one simulation; to compare two, and real frames, all need the same weights.

    Raises UserError when it is no study, or cannot be run so.
    """
    recipe = load_recipe(study, dict(change), effects)
    if not isinstance(recipe, Recipe):
        raise UserError(Fault(where, f"{study} is no study", "a recipe that designs"))
    learning = [name for name, use in recipe.nodes.items() if use.train and use.train.weights != "frozen"]
    if learning:
        frozen = {f"nodes.{name}.train.weights": "frozen" for name in learning}
        recipe = load_recipe(study, {**change, **frozen}, effects)
        assert isinstance(recipe, Recipe)
    return make_plan(recipe, plugins)
