"""Feasibility of the constraints: does any camera keep them, and which of them does none keep."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from tacos_framework.errors import CandidateFailed
from tacos_framework.plan.findings import RecipeFindings
from tacos_framework.plan.plan import Plan
from tacos_framework.quantities import Breach
from tacos_framework.randomness import generator
from tacos_framework.settings import KeyPath
from tacos_framework.variables.design_space import CatalogChoice, DesignSpace

SPREAD_TRIES = 500
"""Cameras drawn from all over the design space before the nearest of them are moved further."""

NEAR_TRIES = 300
"""Cameras near the one that comes nearest, in steps from half the space down to a 20,000th of it."""


@dataclass(frozen=True)
class Infeasible:
    """Every camera that was tried breaks a constraint."""

    tried: int
    unmet: tuple[Breach, ...]
    """For each constraint that none of them keeps, how the one that comes nearest breaks it."""
    nearest: tuple[Breach, ...]
    """Breaches of the camera that comes nearest to keeping all of them."""

    @property
    def sentence(self) -> str:
        """Why, and how near it comes."""
        return "; ".join(breach.sentence for breach in self.unmet or self.nearest)


def infeasible(
    plan: Plan, space: DesignSpace | None = None, fixes: Mapping[str, Any] | None = None
) -> Infeasible | None:
    """Why no camera keeps the constraints; None as soon as one does. Nothing is rendered.

    `space`: what is free; the plan's whole space if None. `fixes`: values of what is not.
    """
    space, fixes = space or plan.space, dict(fixes or {})
    seen: list[tuple[tuple[float, ...], dict[str, Breach]]] = []
    for genes in _tries(space, seen):
        candidate = space.decode(genes)
        values = {**fixes, **candidate.as_dict()}
        derived = derived_of(plan, values)
        if derived is None:
            continue
        breaches = plan.breaches(values, derived)
        if not breaches:
            return None
        seen.append((candidate.genes, {breach.quantity: breach for breach in breaches}))
    if not seen:
        return None  # the rig refuses them all, which is told elsewhere
    names = dict.fromkeys(name for _, broken in seen for name in broken)
    nearest = {
        name: min(
            (broken[name] for _, broken in seen if name in broken), key=lambda b: (not b.known, b.amount)
        )
        for name in names
        if all(name in broken for _, broken in seen)
    }
    return Infeasible(len(seen), tuple(nearest.values()), tuple(_nearest(seen)[1].values()))


def derived_of(plan: Plan, values: Mapping[str, Any]) -> Mapping[str, float] | None:
    """Quantities that the rig derives from plain values; None if it refuses them."""
    try:
        return plan.derived(values)
    except (ValidationError, CandidateFailed):
        return None


def _tries(
    space: DesignSpace, seen: Sequence[tuple[tuple[float, ...], Any]]
) -> Iterator[Sequence[float] | NDArray[np.float64]]:
    """Genes to try: the middle, all over the space, every part of a catalog, and near the best of them."""
    lower = np.array([gene.lower for gene in space.genes])
    upper = np.array([gene.upper for gene in space.genes])
    yield (lower + upper) / 2
    if not space.genes:
        return
    rng = generator(0, "feasibility")
    for _ in range(SPREAD_TRIES):
        yield space.sample(rng).genes
    for variable in space.variables:
        for row in variable.rows if isinstance(variable, CatalogChoice) else ():
            yield space.encode({**space.sample(rng).values, variable.name: row})
    for i in range(NEAR_TRIES if seen else 0):
        step = 0.5 * 10.0 ** (-4 * i / NEAR_TRIES)
        moved = np.array(_nearest(seen)[0]) + rng.normal(0, step, len(lower)) * (upper - lower)
        yield np.clip(moved, lower, upper)


def _nearest(seen: Sequence[tuple[tuple[float, ...], dict[str, Breach]]]) -> tuple[Any, dict[str, Breach]]:
    """The camera whose breaches are smallest, each in shares of the largest that was seen."""
    largest: dict[str, float] = {}
    for _, broken in seen:
        for name, breach in broken.items():
            largest[name] = max(largest.get(name, 0.0), breach.amount)
    return min(seen, key=lambda one: math.fsum(b.amount / largest[n] for n, b in one[1].items()))


def check_feasible(findings: RecipeFindings, plan: Plan) -> None:
    """Constraints that no camera keeps are faults, each at its place, with the camera that comes nearest."""
    found = infeasible(plan)
    if found is None:
        return
    for breach in found.unmet:
        what = f"none of {found.tried} cameras tried keeps it; nearest: {breach.sentence}"
        findings.add(_place(plan, breach.quantity), what, "", "Relax it, or widen the design space.")
    if not found.unmet:
        what = f"none of {found.tried} cameras tried keeps all constraints; nearest: {found.sentence}"
        findings.add(("constraints",), what, "", "Relax one of them, or widen the design space.")


def _place(plan: Plan, name: str) -> KeyPath:
    """Position of a constraint in the recipe; for one of the rig's own, that of the design."""
    return ("constraints", name) if name in plan.recipe.constraints else ("design",)
