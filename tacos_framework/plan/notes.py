"""Notes for whoever builds the camera of a study, about its parts and constraints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tacos_framework.catalog import CatalogPart, Grade, in_words
from tacos_framework.contracts import OptimizerBase, RigBase, SceneBase, optional
from tacos_framework.plan.feasibility import derived_of, infeasible
from tacos_framework.plan.plan import Plan
from tacos_framework.variables.design_space import CatalogChoice

ASK_THE_MAKER: tuple[Grade, ...] = ("derived", "hobby list")
"""Grades nobody who stands for the part has confirmed."""

NAMED = 10
"""Parts that a note names before it counts the others."""


def notes_on_constraints(plan: Plan) -> Iterator[str]:
    """On constraints that parts keep as nobody knows better, and on products that break one."""
    for name, variable, parts in _unknown_parts(plan):
        if len(parts) == len(variable.rows):
            yield (
                f"No part with a published {name} keeps the constraint on it. Not published for "
                f"{_first_of(parts)} ({variable.name}). Relax the constraint, or set unknown: refuse."
            )
        else:
            yield (
                f"The constraint on {name} passes parts that do not publish it: "
                f"{_first_of(parts)} ({variable.name}); unknown: refuse leaves them out."
            )
    titles = {camera.name: camera.title for camera in plan.cameras}
    for product, why in inadmissible(plan).items():
        yield f"{titles[product]} ({product}) breaks a constraint: {why}."


def notes_on_search(plan: Plan) -> Iterator[str]:
    """Remarks of the optimizer on a search with its settings."""
    optimizer = plan.optimizer
    if callable(notes := optional(optimizer.cls, OptimizerBase, "notes")):
        with optimizer.calling("notes"):
            yield from list(notes(optimizer.config, plan.space))


def notes_on_catalogs(plan: Plan) -> Iterator[str]:
    """On parts that cannot be chosen, by the reason."""
    for variable in catalog_choices(plan):
        by_reason: dict[str, list[str]] = {}
        for name, reason in variable.reasons.items():
            by_reason.setdefault(reason, []).append(name)
        for reason, names in sorted(by_reason.items(), key=lambda item: -len(item[1])):
            yield (
                f"{len(names)} of {len(variable.catalog.rows)} parts of {variable.catalog.name} cannot be "
                f"chosen, {reason}: {_first_of(names)}."
            )


@dataclass(frozen=True)
class DoubtedParts:
    """Doubts about the parts of one catalog that can be chosen."""

    catalog: str
    parts: int
    """Number of parts that can be chosen."""
    by_doubt: Mapping[str, tuple[str, ...]]
    """Each doubt once, with the names of the parts it is about; those of many parts first."""

    @property
    def doubted(self) -> int:
        return len({name for names in self.by_doubt.values() for name in names})


def doubted_parts(plan: Plan) -> Iterator[DoubtedParts]:
    """Of each catalog a study chooses from, the doubts about its parts, where there are any."""
    for variable in catalog_choices(plan):
        found: dict[str, tuple[str, ...]] = {}
        for part in variable.rows:
            for doubt in part.doubts:
                found[doubt] = (*found.get(doubt, ()), part.name)
        if found:
            many_first = dict(sorted(found.items(), key=lambda item: -len(item[1])))
            yield DoubtedParts(variable.catalog.name, len(variable.rows), many_first)


def catalog_choices(plan: Plan) -> Iterator[CatalogChoice]:
    return (each for each in plan.space.variables if isinstance(each, CatalogChoice))


def _first_of(items: Sequence[str]) -> str:
    more = f" and {len(items) - NAMED} more" if len(items) > NAMED else ""
    return f"{', '.join(items[:NAMED])}{more}"


def inadmissible(plan: Plan) -> dict[str, str]:
    """Products that break a constraint however what they leave free is chosen: name and why."""
    found = {camera.name: infeasible(plan, plan.free_of(camera), camera.fixes) for camera in plan.cameras}
    return {name: broken.sentence for name, broken in found.items() if broken is not None}


AT_BOUND = 0.01
"""A variable this near to a bound, as a share of its range, stands at it."""


def notes_on_bounds(plan: Plan, values: Mapping[str, Any]) -> Iterator[str]:
    """Variables of a camera that stand at the end of their range, in a sentence each."""
    for variable in plan.space.as_data():
        value, lower, upper = (values.get(variable["name"]), variable.get("lower"), variable.get("upper"))
        if not isinstance(value, int | float) or lower is None or upper is None:
            continue
        near = min((lower, upper), key=lambda end: abs(value - end))
        if abs(value - near) <= AT_BOUND * (upper - lower):
            unit = "" if variable["unit"] in ("", "1") else f" {variable['unit']}"
            yield (
                f"{variable['name']} of the designed camera stands at its bound of {near:g}{unit}: better "
                f"cameras may lie beyond. Widen design.{variable['name']}, or mind why it ends there."
            )


def notes_on_camera(plan: Plan, values: Mapping[str, Any]) -> Iterator[str]:
    """Sentences on one camera: doubts about its parts, what to ask their makers, what its rig says."""
    for variable in catalog_choices(plan):
        name = values.get(variable.name, {}).get("name")
        for row in variable.rows:
            if row.name == name:
                yield from (f"{row.name}: {said}" for said in (*row.doubts, *_to_be_asked(row)))
    notes = optional(plan.rig.instance, RigBase, "notes")
    if callable(notes):
        try:
            with plan.rig.calling("notes"):
                yield from list(notes(plan.rig_variables(values)))
        except Exception as error:  # noqa: BLE001 - a remark must not cost a study its results
            yield f"{plan.rig.origin} has notes on this camera, but fails to say them: {error}"


def notes_on_middle(plan: Plan) -> Iterator[str]:
    """Sentences on the camera in the middle of the design space, where no parts are chosen for it."""
    if next(catalog_choices(plan), None) is None:
        yield from (
            f"In the middle of the design space: {said}" for said in notes_on_camera(plan, middle(plan))
        )


def middle(plan: Plan) -> Mapping[str, Any]:
    """Values in the middle of the design space."""
    return plan.space.decode([(gene.lower + gene.upper) / 2 for gene in plan.space.genes]).as_dict()


def _to_be_asked(part: CatalogPart) -> Iterator[str]:
    """Values of a part that rest on little, with their source, to ask the maker about."""
    found: dict[tuple[Grade, str], list[str]] = {}
    for column, grade in part.grades.items():
        if grade in ASK_THE_MAKER:
            found.setdefault((grade, part.provenance.get(column, "")), []).append(in_words(column))
    for (grade, source), columns in found.items():
        named = f" ({source})" if source else ""
        yield f"Ask the maker for {', '.join(columns)}, of grade {grade!r} here{named}."


def _unknown_parts(plan: Plan) -> Iterator[tuple[str, CatalogChoice, tuple[str, ...]]]:
    """Of each constraint: its quantity, a variable, and the parts that can be chosen nobody states it of.

    Only where other parts of the same catalog have it, be they ruled out: a rig without a lens has no image
    circle.
    """
    values = middle(plan)
    for variable in catalog_choices(plan):
        candidates = [{**values, variable.name: row.as_dict()} for row in variable.rows]
        unknown = [plan.unknown(each, derived_of(plan, each) or {}) for each in candidates]
        for constraint in plan.constraints:
            known = zip(variable.rows, unknown, strict=True)
            names = tuple(row.name for row, missing in known if constraint.quantity in missing)
            is_had = len(names) < len(candidates) or _rules_out_parts(constraint.quantity, variable)
            if names and is_had and constraint.unknown == "allow":
                yield constraint.quantity, variable, names


def _rules_out_parts(quantity: str, variable: CatalogChoice) -> bool:
    """True if a quantity is a column of the parts, and known of one that is ruled out."""
    owner, _, column = quantity.partition(".")
    ruled_out = [row for row in variable.catalog.rows if row.name in variable.excluded]
    return owner == variable.name and any(row.as_dict().get(column) is not None for row in ruled_out)


def notes_on_worlds(plan: Plan) -> Iterator[str]:
    """Doubts about the files of scenes, and statements in them that are not carried out; opens the files.

    Raises `UserError` with what is wrong with such a file.
    """
    for name in plan.graph.of_kind("scene"):
        scene = plan.nodes[name]
        with scene.calling("as it looks through its files"):
            told: tuple[str, ...] = optional(scene.instance, SceneBase, "remarks")
        yield from told
