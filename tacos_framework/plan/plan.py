"""What a plan is."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tacos_framework.catalog import OffTheShelf
from tacos_framework.contracts import learns
from tacos_framework.fitness import Constraint, Fitness
from tacos_framework.graph import Graph
from tacos_framework.plan.component import ConfiguredComponent, EffectPart
from tacos_framework.plan.targets import Target, target_of
from tacos_framework.recipe import Recipe
from tacos_framework.settings import Settings
from tacos_framework.variables.design_space import DesignSpace

REFUSED: Mapping[str, float] = {"rig": 1.0}
"""What a candidate breaks that the rig refuses; there is no telling by how much."""


@dataclass(frozen=True)
class Plan:
    """A recipe with everything found and checked.

    Parameters
    ----------
    recipe
        The recipe.
    graph
        The wired graph.
    nodes
        The component of each node.
    rig
        The component that builds the rig.
    fixed
        Variables of the rig that the recipe fixes.
    space
        The variables it designs.
    effects
        Effects in the order of image formation.
    """

    recipe: Recipe
    graph: Graph
    nodes: Mapping[str, ConfiguredComponent]
    rig: ConfiguredComponent
    fixed: Mapping[str, Any]
    space: DesignSpace
    fitness: Fitness
    constraints: tuple[Constraint, ...]
    effects: tuple[EffectPart, ...]
    optimizer: ConfiguredComponent
    executor: ConfiguredComponent
    cameras: tuple[OffTheShelf, ...] = ()

    def target(self, variable: str) -> Target:
        """What a design variable of that name sets."""
        return target_of(variable, self.recipe.effect_names)

    @property
    def trainable(self) -> tuple[str, ...]:
        """Task nodes that learn."""
        return tuple(n for n in self.graph.of_kind("task") if learns(self.nodes[n].cls))

    def rig_variables(self, values: Mapping[str, Any]) -> Settings:
        """The rig's variables for plain values of the design variables.

        Raises
        ------
        pydantic.ValidationError
            When the rig refuses a value.
        """
        own = {name: value for name, value in values.items() if "." not in name}
        return self.rig.cls.Variables.model_validate_json(json.dumps({**self.fixed, **own}))

    def broken(self, derived: Mapping[str, float]) -> dict[str, float]:
        """By how much derived quantities break each constraint they break, in the unit of the quantity."""
        excesses = {constraint.quantity: constraint.excess(derived) for constraint in self.constraints}
        return {quantity: excess for quantity, excess in excesses.items() if excess > 0}
