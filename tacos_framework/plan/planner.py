"""Makes the plan of a recipe, section by section."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tacos_framework.contracts import RigBase, optional
from tacos_framework.errors import Fault, UserError
from tacos_framework.fitness import Fitness, FitnessTerm
from tacos_framework.plan.bounded import boundable, find_constraints, find_objectives, narrowed
from tacos_framework.plan.checks import (
    check_margins,
    check_scenarios,
    check_scores,
    declared_margins,
    find_cameras,
)
from tacos_framework.plan.component import ConfiguredComponent
from tacos_framework.plan.design import find_space
from tacos_framework.plan.effects import check_wanted_files, find_effects
from tacos_framework.plan.exposure import find_exposure
from tacos_framework.plan.feasibility import check_feasible
from tacos_framework.plan.findings import RecipeFindings
from tacos_framework.plan.nodes import find_nodes
from tacos_framework.plan.plan import Plan
from tacos_framework.plan.rig import find_rig
from tacos_framework.plan.shown import check_truth
from tacos_framework.plan.units import check_exposures, check_image_sizes
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import NamedScenario, Recipe


def make_plan(recipe: Recipe, plugins: Plugins, faults: Sequence[Fault] = ()) -> Plan:
    """Check a recipe against the installed plugins.

    `recipe`: the recipe; may be a draft when `faults` says so.

    Raises `UserError` with those faults and all that are found here.
    """
    findings = RecipeFindings(recipe, plugins, list(faults))
    plan = _plan(findings)
    if findings.faults or plan is None:
        raise UserError(findings.in_order())
    return plan


def _plan(findings: RecipeFindings) -> Plan | None:
    recipe = findings.recipe
    nodes, graph = find_nodes(findings)
    rig, fixed = find_rig(findings)
    effects = find_effects(findings)
    if graph is not None and len(nodes) == len(recipe.nodes):
        check_wanted_files(findings, graph, nodes, effects)
        check_truth(findings, graph, nodes)
    exposure = find_exposure(findings, nodes)
    check_scenarios(findings)
    space = find_space(findings, rig, fixed, nodes, effects, exposure)
    known = boundable(rig, fixed, space)
    constraints = find_constraints(findings, known)
    objectives = find_objectives(findings, known, nodes)
    check_scores(findings, nodes)
    check_margins(findings)
    optimizer = findings.part(recipe.optimizer, "optimizer", ("optimizer",)) if recipe.optimizer else None
    executor = findings.executor()
    cameras = find_cameras(findings, rig)
    if findings.faults or not (graph and rig and space and optimizer and executor):
        return None
    bounded = {constraint.quantity for constraint in constraints}
    own = tuple(c for c in optional(rig.cls, RigBase, "buildable") if c.quantity not in bounded)
    plan = Plan(
        recipe=recipe,
        graph=graph,
        nodes=nodes,
        rig=rig,
        fixed=fixed,
        space=narrowed(space, constraints),
        fitness=_fitness(recipe, nodes),
        constraints=constraints + own,
        effects=tuple(effects.values()),
        optimizer=optimizer,
        executor=executor,
        cameras=cameras,
        objectives=objectives,
        exposure=exposure,
    )
    check_feasible(findings, plan)
    check_image_sizes(findings, plan)
    check_exposures(findings, plan)
    return plan


def _fitness(recipe: Recipe, nodes: Mapping[str, ConfiguredComponent]) -> Fitness:
    margins = {**declared_margins(nodes), **(recipe.test.margins if recipe.test else {})}
    terms = tuple(
        FitnessTerm(each.score, each.weight, margins.get(each.score, 0.0)) for each in recipe.fitness
    )
    weights = tuple((s.name, s.weight) for s in recipe.scenarios if isinstance(s, NamedScenario))
    return Fitness(terms, weights, recipe.study.scenarios)
