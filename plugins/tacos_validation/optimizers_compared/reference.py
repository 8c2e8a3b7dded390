"""The best camera on the held-out scenes: looked for on those scenes themselves."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from tacos_framework import Candidate, Fault, UserError
from tacos_framework.plan import Plan
from tacos_framework.simulation import EpisodeSpec
from tacos_framework.study import broken_by
from tacos_validation.optimizers_compared.grid import Stepped, coarse_grid, count_coarse, neighbours, stride
from tacos_validation.optimizers_compared.settings import ReferenceSearch
from tacos_validation.score_table import ScoreTable


def admissible(plan: Plan, asked: ReferenceSearch) -> list[Candidate]:
    """The cameras of the coarse grid that break no constraint.

    Raises UserError when there are too many, or none.
    """
    count = count_coarse(plan.space, asked.coarse)
    if count > asked.most:
        raise UserError(
            Fault(
                "reference",
                f"the coarse grid has {count} cameras",
                f"at most {asked.most}",
                "Give larger steps under reference.coarse, or raise reference.most.",
            )
        )
    found = [each for each in coarse_grid(plan.space, asked.coarse) if not broken_by(plan, each.as_dict())]
    if not found:
        raise UserError(
            Fault(
                "reference",
                f"none of the {count} cameras of the coarse grid keeps the constraints of the problem",
                "",
                "Relax them, or give smaller steps under reference.coarse.",
            )
        )
    return found


def climb(
    plan: Plan,
    asked: ReferenceSearch,
    coarse: Sequence[Candidate],
    table: ScoreTable,
    specs: Sequence[EpisodeSpec],
    on_row: Callable[[str], None],
) -> Mapping[str, Any]:
    """The best camera found on these scenes; everything tried is in the table afterwards.

    The coarse grid, as `admissible` gives it, is scored on the first of them. The best of different choices
    of parts then climb on all of them: to the best neighbour while there is a better one, in strides that
    are halved down to the fine grid.

    Raises UserError when nothing on the coarse grid can be scored.
    """
    first = specs[: asked.scenes]
    table.fill([(each.as_dict(), spec) for each in coarse for spec in first], on_row)
    scored = {each: fitness for each in coarse if (fitness := _fitness(table, each, first)) is not None}
    if not scored:
        why = table.evaluation(coarse[0].as_dict(), first).failed
        raise UserError(Fault("problem", f"no camera of the coarse grid can be scored: {why}"))
    climbers = _best_of_each_choice(scored, plan)[: asked.climbs]
    strides = {v.name: stride(v, asked.coarse) for v in plan.space.variables if isinstance(v, Stepped)}
    best = _best(table, climbers, specs, on_row)
    while True:
        strides = {name: max(1, steps // 2) for name, steps in strides.items()}
        climbers = [_climbed(plan, table, specs, each, strides, on_row) for each in climbers]
        best = _best(table, [best, *climbers], specs, on_row)
        if all(steps == 1 for steps in strides.values()):
            return best.as_dict()


def _climbed(
    plan: Plan,
    table: ScoreTable,
    specs: Sequence[EpisodeSpec],
    start: Candidate,
    strides: Mapping[str, int],
    on_row: Callable[[str], None],
) -> Candidate:
    """The top of the hill that a candidate stands on, in strides of this length."""
    here = start
    while True:
        around = [n for n in neighbours(plan.space, here, strides) if not broken_by(plan, n.as_dict())]
        there = _best(table, [here, *around], specs, on_row)
        if there == here:
            return here
        here = there


def _best(
    table: ScoreTable,
    candidates: Sequence[Candidate],
    specs: Sequence[EpisodeSpec],
    on_row: Callable[[str], None],
) -> Candidate:
    """The best of some candidates; of equal ones the first."""
    table.fill([(each.as_dict(), spec) for each in candidates for spec in specs], on_row)
    fitness = [_fitness(table, each, specs) for each in candidates]
    return max(
        zip(candidates, fitness, strict=True),
        key=lambda pair: float("-inf") if pair[1] is None else pair[1],
    )[0]


def _best_of_each_choice(scored: Mapping[Candidate, float], plan: Plan) -> list[Candidate]:
    """For every choice of parts and words the best candidate, the best of them first."""
    chosen = [v.name for v in plan.space.variables if not isinstance(v, Stepped)]
    best: dict[str, Candidate] = {}
    for candidate in sorted(scored, key=lambda each: -scored[each]):
        best.setdefault(repr([candidate.as_dict()[name] for name in chosen]), candidate)
    return list(best.values())


def _fitness(table: ScoreTable, candidate: Candidate, specs: Sequence[EpisodeSpec]) -> float | None:
    return table.evaluation(candidate.as_dict(), specs).fitness
