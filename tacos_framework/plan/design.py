"""What a recipe leaves free, and within which bounds."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from tacos_framework.catalog import find_catalog
from tacos_framework.errors import UserError, did_you_mean
from tacos_framework.plan.camera_fit import check_cameras_fit
from tacos_framework.plan.findings import Findings
from tacos_framework.plan.parts import Part
from tacos_framework.recipe import Between, Choose, FromCatalog, Recipe, Scenario
from tacos_framework.settings import Path, check
from tacos_framework.variables.design_space import (
    CatalogChoice,
    Categorical,
    Continuous,
    DesignSpace,
    Integer,
    Variable,
)


def find_space(
    findings: Findings, rig: Part | None, fixed: Mapping[str, Any], nodes: Mapping[str, Part]
) -> DesignSpace | None:
    """The design variables; None where there is no rig, or a variable is at fault."""
    design = findings.recipe.design
    variables = []
    for name, entry in design.items():
        unit = _unit(findings, name, rig, nodes)
        if unit is not None and (variable := _variable(findings, name, entry, unit)):
            variables.append(variable)
    if rig is None:
        return None
    given = {*fixed, *design}
    for name, info in rig.cls.Variables.model_fields.items():
        if info.is_required() and name not in given:
            findings.add(
                ("rig",),
                f"{rig.use} needs {name!r}",
                info.description or "",
                "Give it under rig: (fixed) or design: (designed).",
            )
    if len(variables) < len(design) or not variables:
        return None
    space = DesignSpace(tuple(variables))
    _check_corners(findings, rig, fixed, space, given)
    if not findings.faults:
        check_cameras_fit(findings, rig, fixed, space, nodes)
    return space


def _unit(findings: Findings, name: str, rig: Part | None, nodes: Mapping[str, Part]) -> str | None:
    """Unit of a design variable; None, and a fault, when there is no such variable."""
    node, _, setting = name.partition(".")
    if not setting:
        fields = rig.cls.Variables.model_fields if rig else {}
        owner = rig.use if rig else "the rig"
        if rig is None:
            return "1"
    elif node == "scenario":
        fields, owner = Scenario.model_fields, "scenario"
    elif node in nodes:
        fields, owner = nodes[node].cls.Config.model_fields, nodes[node].use
    elif node in findings.recipe.nodes:
        return "1"  # its component is at fault already
    else:
        remedy = did_you_mean(node, findings.recipe.nodes)
        findings.add(("design", name), f"there is no node {node!r}", "", remedy)
        return None
    if (wanted := setting or node) not in fields:
        findings.add(
            ("design", name), f"{owner} has no variable {wanted!r}", "", did_you_mean(wanted, fields)
        )
        return None
    extra = fields[wanted].json_schema_extra
    return str(extra.get("unit", "1")) if isinstance(extra, dict) else "1"


def _variable(findings: Findings, name: str, entry: Any, unit: str) -> Variable | None:
    path = ("design", name)
    try:
        if isinstance(entry, Between):
            lower, upper = entry.between
            if entry.integer:
                return Integer(name, int(lower), int(upper), unit)
            return Continuous(name, lower, upper, unit)
        if isinstance(entry, Choose):
            return Categorical(name, entry.choose)
        if isinstance(entry, FromCatalog):
            catalog = find_catalog(entry.catalog, folder=findings.recipe.folder)
            return CatalogChoice(name, catalog, entry.scheme, entry.columns, entry.distance)
    except UserError as error:
        findings.adopt(path, error)
    except ValueError as error:
        findings.add(path, str(error))
    return None


def _check_corners(
    findings: Findings, rig: Part, fixed: Mapping[str, Any], space: DesignSpace, given: set[str]
) -> None:
    """Try the two corners of the space on the rig, so that bad bounds and fixed values show now."""
    variables = rig.cls.Variables
    if any(info.is_required() and name not in given for name, info in variables.model_fields.items()):
        return
    lower = [gene.lower for gene in space.genes]
    upper = [gene.upper for gene in space.genes]
    seen: set[str] = set()
    for genes in (lower, upper):
        values = {n: v for n, v in space.decode(genes).as_dict().items() if "." not in n}
        where = partial(_where_given, findings.recipe, fixed)
        for fault in check(variables, {**fixed, **values}, where)[1]:
            if fault.where not in seen:
                seen.add(fault.where)
                findings.faults.append(fault)


def _where_given(recipe: Recipe, fixed: Mapping[str, Any], path: Path) -> str:
    """Where a variable of the rig stands in the recipe."""
    section = "rig" if path and path[0] in fixed else "design"
    return recipe.where((section, *path))
