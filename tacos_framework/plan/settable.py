"""Checks of design variables: the setting exists and takes the values."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from pydantic import BaseModel

from tacos_framework.errors import did_you_mean
from tacos_framework.plan.component import ConfiguredComponent, EffectPart
from tacos_framework.plan.findings import RecipeFindings
from tacos_framework.plan.other_keys import keys_of_recipe, remedy_for
from tacos_framework.plan.targets import EXPOSURE, Target, target_of
from tacos_framework.recipe import NamedScenario, Scenario
from tacos_framework.settings import check, unit_of
from tacos_framework.variables.design_space import CatalogChoice, Categorical, Continuous, Variable

_OF_ONE_CAMERA = ("effect", "sensor")
"""Kinds of component that each camera may have with settings of its own."""


@dataclass(frozen=True)
class Settable:
    """Everything that design variables can set; faults go to `findings`."""

    findings: RecipeFindings
    rig: ConfiguredComponent | None
    nodes: Mapping[str, ConfiguredComponent]
    effects: Mapping[str, EffectPart]
    exposure: ConfiguredComponent | None = None

    def target(self, variable: str) -> Target:
        """The target of a design variable, with its type."""
        return target_of(variable, self.findings.recipe.effect_names)

    def unit(self, variable: str) -> str | None:
        """Unit of a design variable; None, and a fault, when there is no such variable."""
        target = self.target(variable)
        settings: type[BaseModel]
        if target.kind == "rig":
            if self.rig is None:
                return "1"
            settings, owner = self.rig.cls.Variables, self.rig.use
        elif target.kind == "scenario":
            if not self._is_scenario(variable, target):
                return None
            settings, owner = Scenario, "scenario"
        else:
            if not self._is_part(variable, target):
                return None
            part = self._part(target)
            if part is None:
                return "1"  # it is at fault already
            settings, owner = part.cls.Config, part.use
        if target.setting not in settings.model_fields:
            what = f"{owner} has no variable {target.setting!r}"
            self._fault(variable, what, "", self._remedy(target, settings))
            return None
        return unit_of(settings, target.setting)

    def _remedy(self, target: Target, own: type[BaseModel]) -> str:
        """Advice about a setting that its owner does not have."""
        keys = keys_of_recipe(self.rig, self.nodes, self.effects, self.exposure)
        alone = target.kind == "rig"
        return remedy_for(target.setting, own, keys, self.findings.plugins, alone=alone)

    def check_values(self, variables: Sequence[Variable]) -> None:
        """Try the ends of each variable, or all it may choose, on what it sets; not on the rig."""
        targets = {variable.name: self.target(variable.name) for variable in variables}
        first: dict[Target, str] = {}
        for name, target in targets.items():
            if (other := first.setdefault(target, name)) != name:
                self._fault(name, f"it sets what {other!r} sets already", "one variable for each setting")
        alone = Counter((target.kind, target.owner, target.camera) for target in targets.values())
        for variable in variables:
            target = targets[variable.name]
            only = alone[target.kind, target.owner, target.camera] == 1
            for config, given in self._configs(target):
                self._check_on(variable, target, config, given, only)

    def _check_on(
        self, variable: Variable, target: Target, config: type[Any], given: Mapping[str, Any], only: bool
    ) -> None:
        """Try the values of a variable on settings; faults of other settings are told elsewhere."""
        owner = variable.name.removesuffix(f".{target.setting}")
        for value in _ends(variable):
            _, faults, paths = check(
                config,
                {**given, target.setting: value},
                lambda _: self.findings.recipe.where(("design", variable.name)),
                owner,
            )
            for fault, path in zip(faults, paths, strict=True):
                own = path[:1] == (target.setting,) or (not path and only)
                if "a whole number" in fault.expected and isinstance(variable, Continuous):
                    fault = replace(fault, remedy="Add integer: true to design whole numbers.")
                if own and fault not in self.findings.faults:
                    self.findings.faults.append(fault)

    def _configs(self, target: Target) -> list[tuple[type[Any], Mapping[str, Any]]]:
        """The settings classes that take a target's value, with the settings the recipe gives."""
        if target.kind == "scenario":
            scenarios = self.findings.recipe.scenarios
            return [
                (type(scenario), scenario.model_dump(mode="json"))
                for scenario in scenarios
                if target.owner in ("", getattr(scenario, "name", ""))
            ]
        part = self._part(target)
        return [] if part is None else [(part.cls.Config, part.config.model_dump(mode="json", by_alias=True))]

    def _part(self, target: Target) -> ConfiguredComponent | None:
        """The component a target belongs to; None where it is at fault, or none."""
        if target.kind == EXPOSURE:
            return self.exposure
        parts: Mapping[str, Mapping[str, ConfiguredComponent]] = {"node": self.nodes, "effect": self.effects}
        return parts.get(target.kind, {}).get(target.owner)

    def _is_scenario(self, variable: str, target: Target) -> bool:
        """True if there is such a scenario; a fault otherwise."""
        names = [s.name for s in self.findings.recipe.scenarios if isinstance(s, NamedScenario)]
        known = target.owner in ("", *names)
        if not known:
            what, expected = f"there is no scenario {target.owner!r}", "scenario.KEY, or scenario.NAME.KEY"
            self._fault(variable, what, expected, did_you_mean(target.owner, names))
        return known

    def _is_part(self, variable: str, target: Target) -> bool:
        """True if there is such a node or effect, for the variable's camera; a fault otherwise."""
        recipe = self.findings.recipe
        if target.kind == EXPOSURE:
            at_fault = recipe.where((EXPOSURE,)) in {fault.where for fault in self.findings.faults}
            if recipe.exposure is None and not at_fault:
                self._fault(variable, "the exposure is fixed", "exposure: {use: control.NAME}")
            return recipe.exposure is not None
        known, expected = recipe.keys_of("nodes"), ""
        if target.kind == "effect":
            known, expected = recipe.effect_names, "effects.NAME.setting, with an effect of the recipe"
        if target.owner == "rig" and self.rig is not None and "rig" not in known:
            remedy = self._remedy(target, self.rig.cls.Variables)
            self._fault(variable, "variables of the rig are named alone", "NAME, not rig.NAME", remedy)
            return False
        if target.owner not in known:
            what = f"there is no {target.kind} {target.owner!r}"
            remedy = did_you_mean(target.owner, known)
            installed = {each.component.use for each in self.findings.plugins}
            if (use := f"effect.{target.owner}") in installed and target.kind == "effect":
                remedy = f"The recipe needs it: effects: [{{use: {use}}}]."
            self._fault(variable, what, expected, remedy)
            return False
        part = self._part(target)
        if part is None or target.camera is None or part.use.partition(".")[0] in _OF_ONE_CAMERA:
            return True
        what = f"{part.use} has no settings for one camera, {target.camera!r}"
        self._fault(variable, what, "an effect or a sensor", f"Call it {target.owner}.{target.setting}.")
        return False

    def _fault(self, variable: str, what: str, expected: str = "", remedy: str = "") -> None:
        self.findings.add(("design", variable), what, expected, remedy)


def _ends(variable: Variable) -> list[Any]:
    """Values to try of a variable."""
    if isinstance(variable, Categorical):
        return list(variable.values)
    if isinstance(variable, CatalogChoice):
        return [variable.rows[0].as_dict()]
    genes = variable.genes
    return [variable.decode([end])[0] for end in (genes[0].lower, genes[0].upper)]
