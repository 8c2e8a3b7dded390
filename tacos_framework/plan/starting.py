"""Settings that are given only as design variables, such as a required one, and values to check them with."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tacos_framework.plan.targets import target_of
from tacos_framework.recipe import Between, Choose, Recipe


def with_starting_values(
    recipe: Recipe, kind: str, owner: str, cls: type[Any], settings: Mapping[str, Any]
) -> dict[str, Any]:
    """The settings of a node or effect, with a first value for those it must have and the recipe designs.

    `kind`, `owner`: ``"node"`` or ``"effect"``, and its name. `settings`: those the recipe gives it.
    """
    names = recipe.effect_names
    fields = cls.Config.model_fields
    started = dict(settings)
    for variable, entry in recipe.design.items():
        target = target_of(variable, names)
        field = fields.get(target.setting)
        if (target.kind, target.owner) != (kind, owner) or field is None or not field.is_required():
            continue
        if isinstance(entry, Between):
            lower = entry.between[0]
            started.setdefault(target.setting, int(lower) if entry.integer else lower)
        elif isinstance(entry, Choose):
            started.setdefault(target.setting, entry.choose[0])
    return started
