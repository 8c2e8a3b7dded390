"""What the design variables of a recipe set: whether there is such a setting, and whether it takes the values."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tacos_framework.errors import did_you_mean
from tacos_framework.plan.findings import Findings
from tacos_framework.plan.parts import EffectPart, Part
from tacos_framework.plan.targets import Target, target_of
from tacos_framework.recipe import NamedScenario, Scenario
from tacos_framework.settings import check
from tacos_framework.variables.design_space import CatalogChoice, Categorical, Variable

_OF_ONE_CAMERA = ("effect", "sensor")
"""Kinds of component that each camera may have with settings of its own."""


@dataclass(frozen=True)
class Settable:
    """Everything that design variables can set; faults go to `findings`."""

    findings: Findings
    rig: Part | None
    nodes: Mapping[str, Part]
    effects: Mapping[str, EffectPart]

    def target(self, variable: str) -> Target:
        """What a design variable sets."""
        return target_of(variable, self.findings.recipe.effect_names)

    def unit(self, variable: str) -> str | None:
        """Unit of a design variable; None, and a fault, when there is no such variable."""
        target = self.target(variable)
        match target.kind:
            case "rig" if self.rig is None:
                return "1"
            case "rig":
                fields, owner = self.rig.cls.Variables.model_fields, self.rig.use
            case "scenario":
                fields, owner = Scenario.model_fields, "scenario"
                if not self._is_scenario(variable, target):
                    return None
            case _:
                part = self._part(variable, target)
                if part is None:
                    return None
                if part == "faulty":
                    return "1"
                fields, owner = part.cls.Config.model_fields, part.use
        if target.setting not in fields:
            what = f"{owner} has no variable {target.setting!r}"
            self._fault(variable, what, "", did_you_mean(target.setting, fields))
            return None
        extra = fields[target.setting].json_schema_extra
        return str(extra.get("unit", "1")) if isinstance(extra, dict) else "1"

    def check_values(self, variables: Sequence[Variable]) -> None:
        """Try the ends of each variable, or all it may choose, on what it sets; the rig is tried elsewhere."""
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
        part = {"node": self.nodes, "effect": self.effects}.get(target.kind, {}).get(target.owner)
        return [] if part is None else [(part.cls.Config, part.config.model_dump(mode="json", by_alias=True))]

    def _is_scenario(self, variable: str, target: Target) -> bool:
        names = [s.name for s in self.findings.recipe.scenarios if isinstance(s, NamedScenario)]
        if target.owner and target.owner not in names:
            what = f"there is no scenario {target.owner!r}"
            self._fault(
                variable, what, "scenario.KEY, or scenario.NAME.KEY", did_you_mean(target.owner, names)
            )
            return False
        return True

    def _part(self, variable: str, target: Target) -> Part | str | None:
        """The component a target belongs to; ``"faulty"`` for one that is at fault already."""
        recipe = self.findings.recipe
        if target.kind == "effect":
            parts: Mapping[str, Part] = self.effects
            known = recipe.effect_names
            form = "effects.NAME.setting, with an effect of the recipe"
        else:
            parts, known, form = self.nodes, recipe.keys_of("nodes"), ""
        if target.owner not in known:
            what = f"there is no {target.kind} {target.owner!r}"
            self._fault(variable, what, form, did_you_mean(target.owner, known))
            return None
        part = parts.get(target.owner)
        if part is None:
            return "faulty"
        if target.camera is not None and part.use.partition(".")[0] not in _OF_ONE_CAMERA:
            what = f"{part.use} has no settings for one camera, {target.camera!r}"
            remedy = f"Call it {target.owner}.{target.setting}."
            self._fault(variable, what, "an effect or a sensor", remedy)
            return None
        return part

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
