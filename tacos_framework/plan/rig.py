"""The rig of a recipe, and which of its variables are fixed."""

from __future__ import annotations

from typing import Any, get_args

from tacos_framework.contracts import RigBase, optional
from tacos_framework.errors import did_you_mean
from tacos_framework.plan.component import ConfiguredComponent
from tacos_framework.plan.findings import RecipeFindings
from tacos_framework.settings import Settings, also_called, with_paths_from


def find_rig(findings: RecipeFindings) -> tuple[ConfiguredComponent | None, dict[str, Any]]:
    """The component that builds the rig, and the values of the variables that are fixed."""
    use = findings.recipe.rig
    cls = findings.component(use.use, "rig", ("rig",)) if use else None
    if use is None or cls is None:
        return None, {}
    variables = cls.Variables.model_fields
    fixed = {name: value for name, value in use.settings.items() if name in variables}
    fixed = with_paths_from(lambda name: findings.recipe.folder_of(("rig", name)), cls.Variables, fixed)
    known = {name: value for name, value in use.settings.items() if name in cls.Config.model_fields}
    for name in use.settings:
        if name not in variables and name not in cls.Config.model_fields:
            remedy = did_you_mean(
                name,
                [*variables, *cls.Config.model_fields],
                also_called(cls.Variables) | also_called(cls.Config),
            )
            findings.add(
                ("rig", name), f"unknown key {name!r}", f"a setting or variable of {use.use}", remedy
            )
    for name in fixed:
        if name in findings.recipe.design:
            findings.add(
                ("rig", name), f"{name!r} is fixed here and designed under design:", "one of the two"
            )
    return findings.configured(cls, use.use, known, ("rig",)), fixed


def part_class(rig: ConfiguredComponent, variable: str) -> type[Settings] | None:
    """A rig's class for a part, where that variable of it is one."""
    info = rig.cls.Variables.model_fields.get(variable)
    kinds = get_args(info.annotation) or (info.annotation,) if info else ()
    return next((kind for kind in kinds if isinstance(kind, type) and issubclass(kind, Settings)), None)


def stand_ins(rig: ConfiguredComponent, given: set[str]) -> set[str]:
    """Variables that need not be given, as others stand for them: a sensor for the camera it is in."""
    groups = optional(rig.cls, RigBase, "alternatives")
    return {name for group in groups if not given.isdisjoint(group) for name in group}
