"""The design problem that is searched: a recipe, on a grid, with scenes that never change."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from tacos_framework import Fault, Plugins, Test, UserError
from tacos_framework.plan import Plan, make_plan
from tacos_framework.simulation import EpisodeSpec
from tacos_validation.harness import FaultsTogether, study_recipe
from tacos_validation.optimizers_compared.grid import on_grid
from tacos_validation.optimizers_compared.settings import CompareOptimizersConfig, HeldOut


@dataclass(frozen=True)
class Contenders:
    """The problem with each of the optimizers. `plans`: by name of the optimizer; equal but for it."""

    plans: Mapping[str, Plan]
    notes: tuple[str, ...]

    @property
    def problem(self) -> Plan:
        return next(iter(self.plans.values()))


def contenders_of(config: CompareOptimizersConfig, plugins: Plugins) -> Contenders:
    """The problem, checked, with each optimizer in turn.

    Raises UserError with everything that is wrong with the problem, its grid or any optimizer that is not
    optional.
    """
    loaded = study_recipe(config.problem, config.change, key="problem")
    study = loaded.study.model_copy(update={"renew_episodes": "never"})
    held_out = config.held_out  # its test scenes here, so that as many worlds are kept
    test = Test(seed=held_out.seed, frames=held_out.frames, episodes=held_out.episodes)
    recipe = loaded.model_copy(update={"study": study, "compare": None, "test": test})
    plan = make_plan(recipe, plugins)
    if plan.trainable:
        raise UserError(
            Fault(
                "problem",
                f"{config.problem} trains a task, so fitness depends on more than the candidate",
                "a problem whose tasks do not learn",
            )
        )
    space = on_grid(plan.space, config.grid)
    plans: dict[str, Plan] = {}
    found = FaultsTogether()
    for name, use in config.optimizers.items():
        with found.of(f"optimizers.{name}", optional=name if name in config.optional else ""):
            plans[name] = replace(
                make_plan(recipe.model_copy(update={"optimizer": use}), plugins), space=space
            )
    found.refuse()
    return Contenders(plans, tuple(found.notes))


def held_out_scenes(asked: HeldOut) -> list[EpisodeSpec]:
    return [EpisodeSpec(asked.seed, ("held out", i), asked.frames) for i in range(asked.episodes)]


def values_text(values: Mapping[str, Any]) -> str:
    shown = {name: value["name"] if isinstance(value, Mapping) else value for name, value in values.items()}
    return ", ".join(
        f"{name} {value:g}" if isinstance(value, float) else f"{name} {value}"
        for name, value in shown.items()
    )
