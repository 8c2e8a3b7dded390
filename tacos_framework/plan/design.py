"""The variables that a recipe leaves free, with their bounds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from tacos_framework.catalog import find_catalog
from tacos_framework.errors import UserError, did_you_mean
from tacos_framework.plan.camera_fit import check_cameras_fit
from tacos_framework.plan.cameras import check_camera_names
from tacos_framework.plan.component import ConfiguredComponent, EffectPart
from tacos_framework.plan.findings import RecipeFindings
from tacos_framework.plan.rig import part_class, stand_ins
from tacos_framework.plan.settable import Settable
from tacos_framework.recipe import Between, Choose, FromCatalog, Recipe
from tacos_framework.settings import KeyPath, check
from tacos_framework.variables.design_space import (
    CatalogChoice,
    Categorical,
    Continuous,
    DesignSpace,
    Integer,
    Variable,
)


def find_space(
    findings: RecipeFindings,
    rig: ConfiguredComponent | None,
    fixed: Mapping[str, Any],
    nodes: Mapping[str, ConfiguredComponent],
    effects: Mapping[str, EffectPart],
    exposure: ConfiguredComponent | None,
) -> DesignSpace | None:
    """The design variables; None where there is no rig, or a variable is at fault."""
    design = findings.recipe.design
    settable = Settable(findings, rig, nodes, effects, exposure)
    variables = []
    for name, entry in design.items():
        unit = settable.unit(name)
        if unit is not None and (variable := _variable(findings, name, entry, unit)):
            variables.append(variable)
    settable.check_values(variables)
    if rig is None:
        return None
    given = {*fixed, *findings.recipe.keys_of("design")}
    settled = given | stand_ins(rig, given)
    for name, info in rig.cls.Variables.model_fields.items():
        if info.is_required() and name not in settled:
            findings.add(
                ("rig",),
                f"{rig.use} needs {name!r}",
                info.description or "",
                "Give it under rig: (fixed) or design: (designed).",
            )
    if len(variables) < len(findings.recipe.keys_of("design")) or not variables:
        return None
    space = DesignSpace(tuple(variables))
    if _lack_columns(findings, rig, space):
        return None
    space = DesignSpace([_of_fit_parts(findings, rig, variable) for variable in space.variables])
    if any(isinstance(variable, CatalogChoice) and not variable.rows for variable in space.variables):
        return None
    _check_corners(findings, rig, fixed, space, settled)
    if not findings.faults:
        check_camera_names(findings, rig, fixed, space, nodes, effects)
    if not findings.faults:
        check_cameras_fit(findings, rig, fixed, space, nodes, effects)
    return space


def _variable(findings: RecipeFindings, name: str, entry: Any, unit: str) -> Variable | None:
    path: KeyPath = ("design", name)
    if isinstance(entry, FromCatalog):
        path = (*path, "from")
    try:
        if isinstance(entry, Between):
            lower, upper = entry.between
            if entry.integer:  # bounds that are not whole are refused with their values
                low, high = (int(bound) if bound.is_integer() else bound for bound in (lower, upper))
                return Integer(name, low, high, unit)  # type: ignore[arg-type]
            return Continuous(name, lower, upper, unit)
        if isinstance(entry, Choose):
            return Categorical(name, entry.choose)
        if isinstance(entry, FromCatalog):
            catalog = find_catalog(entry.catalog, folder=findings.recipe.folder_of(path))
            if entry.only is not None:
                path = ("design", name, "only")
                catalog = replace(catalog, rows=tuple(map(catalog.part, dict.fromkeys(entry.only))))
            return CatalogChoice(name, catalog, entry.scheme or catalog.scheme, entry.columns, entry.distance)
    except UserError as error:
        findings.adopt(path, error)
    except ValueError as error:
        findings.add(path, str(error))
    return None


def _of_fit_parts(findings: RecipeFindings, rig: ConfiguredComponent, variable: Variable) -> Variable:
    """The variable without the parts that the rig cannot take; a fault where it takes none."""
    kind = part_class(rig, variable.name)
    if kind is None or not isinstance(variable, CatalogChoice):
        return variable
    unfit = {}
    for row in variable.rows:
        known = {name: value for name, value in row.as_dict().items() if value is not None}
        if faults := check(kind, known, str)[1]:
            unfit[row.name] = faults[0].what
    if len(unfit) == len(variable.rows):
        name, reason = next(iter(unfit.items()))
        what = f"{rig.use} takes no part of {variable.catalog.name}; of {name}, {reason}"
        findings.add(
            ("design", variable.name, "from"), what, "", "Choose from another catalog, or another rig."
        )
    return replace(variable, unfit=unfit)


def _lack_columns(findings: RecipeFindings, rig: ConfiguredComponent, space: DesignSpace) -> bool:
    """True if a catalog lacks a column that the rig needs of each part."""
    lacking = False
    for variable in space.variables:
        kind = part_class(rig, variable.name)
        if kind is None or not isinstance(variable, CatalogChoice):
            continue
        columns = {"name", *(column.name for column in variable.catalog.columns)}
        for name, field in kind.model_fields.items():
            if field.is_required() and name not in columns:
                lacking = True
                findings.add(
                    ("design", variable.name, "from"),
                    f"the catalog {variable.catalog.name} has no column {name!r}, which {rig.use} needs",
                    field.description or "",
                    did_you_mean(name, columns) if len(columns) > 1 else "",
                )
    return lacking


def _check_corners(
    findings: RecipeFindings,
    rig: ConfiguredComponent,
    fixed: Mapping[str, Any],
    space: DesignSpace,
    settled: set[str],
) -> None:
    """Try the ends of the space on the rig, so that bad bounds and fixed values show now."""
    variables = rig.cls.Variables
    if any(info.is_required() and name not in settled for name, info in variables.model_fields.items()):
        return
    seen: set[str] = set()
    for values in _corners(space):
        where = partial(_where_given, findings.recipe, fixed)
        for fault in check(variables, {**fixed, **values}, where)[1]:
            if fault.where not in seen:
                seen.add(fault.where)
                findings.faults.append(fault)


def _corners(space: DesignSpace) -> Iterator[dict[str, Any]]:
    """Variables of the rig: all at their lower bound, all at their upper one, and each choice between."""
    lower = space.decode([gene.lower for gene in space.genes]).as_dict()
    upper = space.decode([gene.upper for gene in space.genes]).as_dict()
    choices = [
        {**lower, variable.name: value}
        for variable in space.variables
        if isinstance(variable, Categorical)
        for value in variable.values[1:-1]
    ]
    for values in (lower, upper, *choices):
        yield {name: value for name, value in values.items() if "." not in name}


def _where_given(recipe: Recipe, fixed: Mapping[str, Any], path: KeyPath) -> str:
    """Position of a rig's variable in the recipe."""
    section = "rig" if path and path[0] in fixed else "design"
    return recipe.where((section, *path))
