"""Sensors and tasks have to work with any camera that the design may choose."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tacos_framework.contracts import SensorBase, optional
from tacos_framework.plan.component import ConfiguredComponent
from tacos_framework.plan.findings import RecipeFindings
from tacos_framework.recipe import Recipe
from tacos_framework.settings import check
from tacos_framework.variables.design_space import CatalogChoice, DesignSpace

_FITTING_CAMERA = {
    "sensor": (
        "a camera with all the figures it needs",
        "Give the missing figures as settings of the node, or choose from a catalog that has them.",
    ),
    "effect": (
        "cameras with all the figures it needs",
        "Set what is missing in the effect, choose from a catalog that has it, or give unknown: assume.",
    ),
    "task": ("cameras it can judge", "Choose another rig, or other values of its variables."),
}
"""Kind of a node that takes no camera -> what it expects, what to do."""


def check_cameras_fit(
    findings: RecipeFindings,
    rig: ConfiguredComponent,
    fixed: Mapping[str, Any],
    space: DesignSpace,
    nodes: Mapping[str, ConfiguredComponent],
    effects: Mapping[str, ConfiguredComponent],
) -> None:
    """Ask whoever does not take every camera whether it takes any that can be chosen."""
    asking = {
        name: part
        for name, part in {**nodes, **{f"effects.{name}": part for name, part in effects.items()}}.items()
        if callable(optional(part.cls, SensorBase, "lacks"))
        and not any(variable.name.startswith(f"{name}.") for variable in space.variables)
    }
    if not asking:
        return
    rigs = _choosable_rigs(findings.recipe, rig, fixed, space)
    for name, part in asking.items():
        with part.calling(f"lacks of {name!r}"):
            reasons = [part.instance.lacks(each) for each in rigs]
        wanted, remedy = _FITTING_CAMERA.get(part.use.partition(".")[0], _FITTING_CAMERA["task"])
        if reasons and all(reasons):
            findings.add(
                ("nodes", name) if name in nodes else ("effects",),
                min(map(str, reasons), key=len),  # of the camera that lacks least
                f"{wanted}; of {len(reasons)} tried there is none",
                remedy,
            )


def _choosable_rigs(
    recipe: Recipe, rig: ConfiguredComponent, fixed: Mapping[str, Any], space: DesignSpace
) -> list[Any]:
    """The rig for every row of each catalog the recipe chooses from; all else at its lower bound."""
    corner = space.decode([gene.lower for gene in space.genes]).as_dict()
    own = {name: value for name, value in corner.items() if "." not in name}
    choices = [v for v in space.variables if isinstance(v, CatalogChoice) and v.name in own]
    tried = [{**own, choice.name: row.as_dict()} for choice in choices for row in choice.rows] or [own]
    builder = rig.instance
    built = []
    for values in tried:
        variables, faults, _ = check(rig.cls.Variables, {**fixed, **values}, recipe.where)
        if not faults:
            with rig.calling("build"):
                built.append(builder.build(variables))
    return built
