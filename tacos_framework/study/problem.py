"""The problem of a study, for its optimizer, beside the design space: `DesignProblem`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import Any

from pydantic import ValidationError

from tacos_framework.contracts import DesignProblem, RigBase, ScoreScale, optional
from tacos_framework.errors import ContractBroken
from tacos_framework.plan import REFUSED, Plan
from tacos_framework.variables import CatalogChoice, Categorical
from tacos_framework.variables.design_space import Candidate


def design_problem(
    plan: Plan, fixed: Mapping[str, Any] | None = None, *, weights_learn: bool = False
) -> DesignProblem:
    """The problem of searching what is free in a plan.

    `fixed`: plain values of the variables that are not searched, as of a product.
    """
    study = plan.recipe.study
    fixed = dict(fixed or {})

    def values_of(candidate: Candidate) -> dict[str, Any]:
        return {**fixed, **candidate.as_dict()}

    return DesignProblem(
        fitness=plan.fitness,
        episodes=study.episodes * study.blocks,
        coordinates=lambda candidate: coordinates_of(plan, values_of(candidate)),
        broken=lambda candidate: broken_by(plan, values_of(candidate)),
        scales=_scales(plan),
        depends_on=_dependencies(plan),
        weights_learn=weights_learn,
        episodes_renew=study.renew_episodes == "each_generation",
    )


def coordinates_of(plan: Plan, values: Mapping[str, Any]) -> dict[str, float]:
    """Coordinates that images depend on, by name, for a candidate that breaks nothing.

    Beside what the rig declares (`RigBuilder`) these are the design variables of nodes, effects and
    scenarios: numbers as they are, words and switches as their place among the values to choose from. For a
    rig that declares nothing, they are what it derives, and its own variables in the same way, of a part from
    a catalog those columns that are known for all parts.

    `values`: plain values of all design variables, as `Evaluation.values` has them.

    Raises `ContractBroken` when the rig gives what is no number.
    """
    own, others = _split(plan, values)
    if callable(declared := optional(plan.rig.instance, RigBase, "coordinates")):
        variables = plan.rig_variables(values)
        with plan.rig.calling("coordinates"):
            found = _numbers(plan, declared(variables))
    else:
        found = _numbers(plan, plan.derived(values))
        found |= {name: value for each in own for name, value in _as_numbers(plan, each, values[each])}
    return found | {name: value for each in others for name, value in _as_numbers(plan, each, values[each])}


def broken_by(plan: Plan, values: Mapping[str, Any]) -> dict[str, float]:
    """By how much a candidate breaks each constraint, in the unit of its quantity; nothing is rendered."""
    try:
        derived = plan.derived(values)
    except ValidationError:
        return dict(REFUSED)
    except Exception:  # noqa: BLE001 - a defect of the rig: the candidate's evaluation says so, if it is asked
        return {}
    return plan.broken(values, derived)


def _split(plan: Plan, values: Mapping[str, Any]) -> tuple[list[str], list[str]]:
    """The design variables of the rig, and those of everything else."""
    designed = [name for name in plan.space.names if name in values]
    own = [name for name in designed if plan.target(name).kind == "rig"]
    return own, [name for name in designed if name not in own]


def _as_numbers(plan: Plan, name: str, value: Any) -> Iterator[tuple[str, float]]:
    """A design variable as numbers, by name; nothing for a value that has no place among its values."""
    variable = next(each for each in plan.space.variables if each.name == name)
    match variable:
        case CatalogChoice():
            for column in _known_columns(variable):
                if _is_number(number := value.get(column)):
                    yield f"{name}.{column}", float(number)
        case Categorical() if not all(_is_number(each) for each in variable.values):
            with suppress(ValueError):  # a product may have what the recipe does not choose from
                yield name, variable.encode(value)[0]
        case _:
            yield name, float(value)


def _known_columns(variable: CatalogChoice) -> list[str]:
    """The columns of numbers that are known for every part to choose from."""
    return [
        column.name
        for column in variable.catalog.columns
        if all(_is_number(row.values.get(column.name)) for row in variable.rows)
    ]


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _numbers(plan: Plan, given: Any) -> dict[str, float]:
    """Numbers by name as the rig gives them."""
    if not isinstance(given, Mapping):
        raise ContractBroken(f"{plan.rig.origin} gives {given!r} where numbers by name are expected")
    for name, value in given.items():
        if not math.isfinite(value):
            raise ContractBroken(f"{plan.rig.origin} gives {value} as {name!r}, which is no finite number")
    return {str(name): float(value) for name, value in given.items()}


def _scales(plan: Plan) -> dict[str, ScoreScale]:
    """The kind of number of each term of the fitness whose task says so."""
    return {score: scales[own] for score, own, scales in _declared(plan, "score_scales") if own in scales}


def _dependencies(plan: Plan) -> dict[str, tuple[str, ...]]:
    """The coordinates that terms of the fitness depend on, where their tasks say so.

    A task speaks of coordinates of the rig; what else is designed may touch its frames. Where it names one
    that this rig does not have, what it depends on here is not known, and so may be anything.
    """
    declared = [each for each in _declared(plan, "depends_on") if each[1] in each[2]]
    if not declared:
        return {}
    lowest = plan.space.decode([gene.lower for gene in plan.space.genes]).as_dict()
    names = list(coordinates_of(plan, lowest))
    _, others = _split(plan, lowest)
    outside = [name for each in others for name, _ in _as_numbers(plan, each, lowest[each])]
    return {
        score: (*named, *outside)
        for score, own, dependencies in declared
        if set(named := tuple(dependencies[own])) <= set(names)
    }


def _declared(plan: Plan, attribute: str) -> Iterator[tuple[str, str, Mapping[str, Any]]]:
    """For each term of the fitness its name, its name within its task, and what the task's class declares."""
    for term in plan.fitness.terms:
        node, _, own = term.score.partition(".")
        yield term.score, own, getattr(plan.nodes[node].cls, attribute, {})
