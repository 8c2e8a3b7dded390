"""Checks of bounds and aims: the quantity exists, and the bounds make sense."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from tacos_framework.catalog import CatalogColumn, CatalogPart
from tacos_framework.catalog.checks import unit_of
from tacos_framework.errors import did_you_mean
from tacos_framework.plan.checks import scores_of
from tacos_framework.plan.component import ConfiguredComponent
from tacos_framework.plan.findings import RecipeFindings
from tacos_framework.quantities import Constraint, Objective, quantity
from tacos_framework.recipe import Bounds
from tacos_framework.settings import KeyPath
from tacos_framework.variables.design_space import CatalogChoice, DesignSpace


@dataclass(frozen=True)
class Boundable:
    """The quantities a recipe may name, each with its column where it is one of a part."""

    units: Mapping[str, str]
    """Name and unit of each."""
    columns: Mapping[str, tuple[CatalogColumn, frozenset[str]]]
    """Those that are columns of a catalog, and the words that stand in them."""
    complete: bool
    """False where a variable is at fault, so that nobody knows the columns of its parts."""

    def lacks(self, name: str) -> bool:
        """True if there is surely no such quantity."""
        return name not in self.units and (self.complete or "." not in name)


def boundable(
    rig: ConfiguredComponent | None, fixed: Mapping[str, Any], space: DesignSpace | None
) -> Boundable | None:
    """Quantities that may be bounded; None without a rig."""
    if rig is None:
        return None
    units = dict(rig.cls.derived_quantities)
    columns = {}
    choices = [v for v in space.variables if isinstance(v, CatalogChoice)] if space else []
    for choice in choices:
        for column in choice.catalog.columns:
            name = f"{choice.name}.{column.name}"
            texts = [row[column.name] for row in choice.catalog.rows]
            words = {word.strip() for text in texts if isinstance(text, str) for word in text.split(",")}
            units[name], columns[name] = column.unit, (column, frozenset(words))
    for owner, part in fixed.items():
        for name in part if isinstance(part, dict) else ():
            units[f"{owner}.{name}"] = unit_of(name) or "1"
    return Boundable(units, columns, space is not None)


def find_constraints(findings: RecipeFindings, known: Boundable | None) -> tuple[Constraint, ...]:
    """The recipe's constraints that make sense; the others are at fault."""
    found = []
    for name, bounds in findings.recipe.constraints.items():
        path = ("constraints", name)
        if known is not None and known.lacks(name):
            what = f"no part to choose has a column {name!r}"
            what = what if "." in name else f"{findings.recipe.rig.use} derives no {name!r}"
            findings.add(path, what, "", did_you_mean(name, known.units))
        elif _make_sense(findings, path, name, bounds, known):
            found.append(Constraint(name, bounds.min, bounds.max, bounds.words, bounds.unknown))
    return tuple(found)


def _make_sense(
    findings: RecipeFindings, path: KeyPath, name: str, bounds: Bounds, known: Boundable | None
) -> bool:
    limits = [limit for limit in (bounds.min, bounds.max) if limit is not None]
    column, words = known.columns.get(name, (None, frozenset())) if known else (None, frozenset())
    if not limits and not bounds.words:
        findings.add(path, f"{name!r} has no bound", "min, max, or both; for text is, or any_of")
    elif len(limits) == 2 and limits[0] > limits[1]:
        findings.add(path, f"min {limits[0]:g} is above max {limits[1]:g}")
    elif limits and column is not None and column.type == "text":
        findings.add(path, f"{name} is text, and has no smallest or largest value", "is, or any_of")
    elif bounds.words and (limits or (column and column.type != "text") or "." not in name):
        findings.add(path, f"{name} is a number, and no word", "min, max, or both")
    else:
        strange = [word for word in bounds.words if column is not None and word not in words]
        for word in strange:
            findings.add(path, f"no part has {word!r} as {name}", "", did_you_mean(word, words))
        return not strange
    return False


def narrowed(space: DesignSpace, constraints: Sequence[Constraint]) -> DesignSpace:
    """The space without the parts that a constraint on one of their own columns rules out.

    Where that leaves no part the choice stays whole: that nothing keeps the constraint is told with the part
    that comes nearest.
    """

    def breaks(row: CatalogPart, variable: str) -> bool:
        values = {variable: row.as_dict()}
        own = [c for c in constraints if c.quantity.startswith(f"{variable}.")]
        return any(c.breach(quantity(c.quantity, values, {})) for c in own)

    variables = []
    for variable in space.variables:
        if isinstance(variable, CatalogChoice):
            excluded = {row.name for row in variable.rows if breaks(row, variable.name)}
            if len(excluded) < len(variable.rows):
                variable = replace(variable, excluded=frozenset(excluded))
        variables.append(variable)
    return DesignSpace(variables)


def find_objectives(
    findings: RecipeFindings, known: Boundable | None, nodes: Mapping[str, ConfiguredComponent]
) -> tuple[Objective, ...]:
    """The aims of a front; what is none is at fault."""
    entries = findings.recipe.objectives
    found: dict[str, Objective] = {}
    for i, entry in enumerate(entries):
        path, name = ("objectives", i, "quantity"), entry.quantity
        units = {"fitness": "1", **dict.fromkeys(scores_of(nodes), "1"), **(known.units if known else {})}
        if name in found:
            findings.add(path, f"{name} stands twice", "each quantity once")
        elif known is not None and known.lacks(name) and name not in units:
            what = f"there is no derived quantity, column of a part, or score {name!r}"
            findings.add(path, what, "", did_you_mean(name, units))
        elif known is not None and name in known.columns and known.columns[name][0].type == "text":
            findings.add(path, f"{name} is text, of which there is no more or less", "a number")
        else:
            found[name] = Objective(name, units.get(name, "1"), entry.aim)
    if len(entries) == 1:
        findings.add(("objectives",), "there is one objective", "two or more, for a front to trade off")
    return tuple(found.values())
