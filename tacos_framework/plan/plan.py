"""A checked recipe, ready to run."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from tacos_framework.catalog import OffTheShelf
from tacos_framework.contracts import RigBase, learns, optional
from tacos_framework.fitness import Fitness
from tacos_framework.graph import Graph
from tacos_framework.plan.component import ConfiguredComponent, EffectPart
from tacos_framework.plan.targets import Target, target_of
from tacos_framework.quantities import Breach, Constraint, Objective, quantity
from tacos_framework.recipe import Recipe
from tacos_framework.settings import Settings
from tacos_framework.variables.design_space import CatalogChoice, DesignSpace

F_NUMBER_MIN = "f_number_min"
"""The derived quantity of a rig that says how far its lens opens, where it knows its lens."""

REFUSED: Mapping[str, float] = {"rig": 1.0}
"""What a candidate breaks that the rig refuses; there is no telling by how much."""


@dataclass(frozen=True)
class Plan:
    """A recipe with everything found and checked.

    Parameters
    ----------
    nodes
        The component of each node.
    rig
        The component that builds the rig.
    fixed
        Variables of the rig that the recipe fixes.
    space
        The variables it designs.
    constraints
        What a candidate must keep: those of the recipe, and those without which the rig cannot be built.
    effects
        Effects in the order of image formation.
    objectives
        Aims that a front trades off; none where the fitness alone counts.
    exposure
        What controls the exposure; None where it is fixed.
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
    objectives: tuple[Objective, ...] = ()
    exposure: ConfiguredComponent | None = None

    def target(self, variable: str) -> Target:
        """The target of the design variable of that name."""
        return target_of(variable, self.recipe.effect_names)

    @property
    def parts(self) -> dict[str, ConfiguredComponent]:
        """The components that results depend on, by the name of their place; all but the executor."""
        effects = {f"effects.{effect.name or number}": effect for number, effect in enumerate(self.effects)}
        exposure = {} if self.exposure is None else {"exposure": self.exposure}
        return {**self.nodes, "rig": self.rig, "optimizer": self.optimizer, **exposure, **effects}

    @property
    def trainable(self) -> tuple[str, ...]:
        """Task nodes that learn."""
        return tuple(n for n in self.graph.of_kind("task") if learns(self.nodes[n].cls))

    def breaches(self, values: Mapping[str, Any], derived: Mapping[str, float]) -> tuple[Breach, ...]:
        """The constraints that a candidate breaks; cheap, as nothing is rendered.

        Parameters
        ----------
        values
            Plain values of its design variables, and of what a product fixes.
        derived
            What the rig derives from them.
        """
        values = {**self._still_fixed(values), **values}
        choices = [v.name for v in self.space.variables if isinstance(v, CatalogChoice)]
        whole = any(name not in values for name in choices)  # a product, which somebody has built already
        found = []
        for constraint in (*self.constraints, *self._widest_aperture(values)):
            if whole:
                constraint = replace(constraint, unknown="allow")
            part = values.get(constraint.quantity.partition(".")[0])
            name = part.get("name", "") if isinstance(part, Mapping) else ""
            found.append(constraint.breach(quantity(constraint.quantity, values, derived), name))
        return tuple(breach for breach in found if breach is not None)

    def broken(self, values: Mapping[str, Any], derived: Mapping[str, float]) -> dict[str, float]:
        """By how much a candidate breaks each constraint, in the unit of its quantity."""
        return {breach.quantity: breach.amount for breach in self.breaches(values, derived)}

    def unknown(self, values: Mapping[str, Any], derived: Mapping[str, float]) -> tuple[str, ...]:
        """Bounded quantities that nobody states for this candidate, and that its constraints allow."""
        values = {**self._still_fixed(values), **values}
        return tuple(c.quantity for c in self.constraints if quantity(c.quantity, values, derived) is None)

    def derived(self, values: Mapping[str, Any]) -> dict[str, float]:
        """Quantities that the rig derives from plain values; raises as `rig_variables` does."""
        variables = self.rig_variables(values)
        with self.rig.calling("derived"):
            return dict(self.rig.instance.derived(variables))

    def _widest_aperture(self, values: Mapping[str, Any]) -> tuple[Constraint, ...]:
        """A lens must open as far as every scenario says, designed f-numbers among them."""
        everywhere = values.get("scenario.f_number")
        named = [
            (getattr(scenario, "name", ""), scenario.f_number if everywhere is None else everywhere)
            for scenario in self.recipe.scenarios
        ]
        f_number = min(values.get(f"scenario.{name}.f_number", given) for name, given in named)
        because = f"exposures are taken at f/{f_number:g}"
        return (Constraint(F_NUMBER_MIN, max=f_number, because=because),)

    def free_of(self, camera: OffTheShelf) -> DesignSpace:
        """The variables that an off-the-shelf camera leaves free."""
        settled = {*camera.fixes, *self._replaced_by(camera.fixes)}
        return self.space.fix([name for name in self.space.names if name in settled])

    def _replaced_by(self, given: Mapping[str, Any]) -> set[str]:
        """Variables of the rig that others stand for: a focal length for a lens."""
        groups = [
            group
            for group in optional(self.rig.cls, RigBase, "alternatives")
            if not given.keys().isdisjoint(group)
        ]
        return {name for group in groups for name in group if name not in given}

    def _still_fixed(self, given: Mapping[str, Any]) -> dict[str, Any]:
        replaced = self._replaced_by(given)
        return {name: value for name, value in self.fixed.items() if name not in replaced}

    def rig_variables(self, values: Mapping[str, Any]) -> Settings:
        """The rig's variables for plain values of the design variables.

        Raises
        ------
        pydantic.ValidationError
            When the rig refuses a value.
        """
        own = {name: value for name, value in values.items() if "." not in name}
        return self.rig.cls.Variables.model_validate_json(json.dumps({**self._still_fixed(own), **own}))
