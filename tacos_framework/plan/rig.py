"""The rig of a recipe, and which of its variables are fixed."""

from __future__ import annotations

from typing import Any

from tacos_framework.errors import did_you_mean
from tacos_framework.plan.component import ConfiguredComponent
from tacos_framework.plan.findings import RecipeFindings
from tacos_framework.settings import also_called, with_paths_from


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
