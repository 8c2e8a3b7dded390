"""A checked recipe, ready to run."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from tacos_framework.catalog import OffTheShelf
from tacos_framework.contracts import RigBase, learns, optional
from tacos_framework.fitness import Fitness
from tacos_framework.graph import Graph
from tacos_framework.plan.component import ConfiguredComponent, EffectPart
from tacos_framework.plan.targets import Target, target_of
from tacos_framework.quantities import Breach, Constraint, Objective, quantity
from tacos_framework.recipe import Recipe, Scenario
from tacos_framework.settings import Settings
from tacos_framework.values import Exposure
from tacos_framework.variables.design_space import CatalogChoice, DesignSpace

F_NUMBER_MIN = "f_number_min"
"""The derived quantity of a rig that says how far its lens opens, where it knows its lens."""

F_NUMBER = "f_number"
"""That of a lens that cannot be changed, as in a product: it stands for the f-number of every scenario."""

EXPOSURE_MIN = "exposure_min_us"
"""That of the shortest exposure a camera can take [us]."""

FRAME_RATE = "frame_rate_fps"
"""That of the most frames a camera takes per second, if exposures are short enough [1/s]."""

REFUSED: Mapping[str, float] = {"rig": 1.0}
"""Breach of a candidate that the rig refuses; there is no telling by how much."""


@dataclass(frozen=True)
class Plan:
    """A recipe with everything found and checked."""

    recipe: Recipe
    graph: Graph
    nodes: Mapping[str, ConfiguredComponent]
    rig: ConfiguredComponent
    fixed: Mapping[str, Any]
    """Variables of the rig that the recipe fixes."""
    space: DesignSpace
    fitness: Fitness
    constraints: tuple[Constraint, ...]
    """Constraints of a candidate: those of the recipe, and those without which the rig cannot be built."""
    effects: tuple[EffectPart, ...]
    optimizer: ConfiguredComponent
    executor: ConfiguredComponent
    cameras: tuple[OffTheShelf, ...] = ()
    objectives: tuple[Objective, ...] = ()
    """Aims that a front trades off; none where the fitness alone counts."""
    exposure: ConfiguredComponent | None = None
    """Control of the exposure; None where it is fixed."""

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

        `values`: plain values of its design variables, and of what a product fixes.
        """
        values = {**self._still_fixed(values), **values}
        kept = self._kept_by_exposures(values, derived)
        choices = [v.name for v in self.space.variables if isinstance(v, CatalogChoice)]
        whole = any(name not in values for name in choices)  # a product, which somebody has built already
        found = []
        for constraint in (*self.constraints, *self._of_scenarios(values)):
            if whole:
                constraint = replace(constraint, unknown="allow")
            if constraint.quantity == FRAME_RATE and kept != derived:
                constraint = replace(constraint, because="exposures leave no more")
            part = values.get(constraint.quantity.partition(".")[0])
            name = part.get("name", "") if isinstance(part, Mapping) else ""
            found.append(constraint.breach(quantity(constraint.quantity, values, kept), name))
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
        return self.derived_of(self.rig_variables(values))

    def derived_of(self, variables: Settings) -> dict[str, float]:
        """Quantities that the rig derives from its variables."""
        with self.rig.calling("derived"):
            return dict(self.rig.instance.derived(variables))

    def exposure_in(self, scenario: Scenario, variables: Settings) -> Exposure:
        """Exposure of a camera in a scenario: with its own f-number, where its lens has but one."""
        f_number = self.derived_of(variables).get(F_NUMBER, scenario.f_number)
        return Exposure(scenario.exposure_ms * 1e-3, f_number, scenario.gain_db)

    def _of_scenarios(self, values: Mapping[str, Any]) -> Iterator[Constraint]:
        """A camera must open as far, and expose as briefly, as every scenario says."""
        f_number = min(self._in_scenarios("f_number", values))
        yield Constraint(F_NUMBER_MIN, max=f_number, because=f"exposures are taken at f/{f_number:g}")
        if self.exposure is None:
            shortest_ms = min(self._in_scenarios("exposure_ms", values))
            yield Constraint(
                EXPOSURE_MIN, max=shortest_ms * 1e3, because=f"an exposure is {shortest_ms:g} ms"
            )

    def _kept_by_exposures(self, values: Mapping[str, Any], derived: Mapping[str, float]) -> dict[str, float]:
        """The derived quantities with the frame rate that exposures leave, each within a frame."""
        if self.exposure is not None or FRAME_RATE not in derived:
            return dict(derived)
        longest_ms = max(self._in_scenarios("exposure_ms", values))
        return {**derived, FRAME_RATE: min(derived[FRAME_RATE], 1e3 / longest_ms)}

    def _in_scenarios(self, key: str, values: Mapping[str, Any]) -> list[float]:
        """A setting in each scenario, as it is designed where it is."""
        everywhere = values.get(f"scenario.{key}")
        return [
            values.get(
                f"scenario.{getattr(scenario, 'name', '')}.{key}",
                getattr(scenario, key) if everywhere is None else everywhere,
            )
            for scenario in self.recipe.scenarios
        ]

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

        Raises `pydantic.ValidationError` when the rig refuses a value.
        """
        own = {name: value for name, value in values.items() if "." not in name}
        return self.rig.cls.Variables.model_validate_json(json.dumps({**self._still_fixed(own), **own}))
