"""Checks of scenarios, fitness, and the cameras off the shelf beside the design."""

from __future__ import annotations

from collections.abc import Mapping

from tacos_framework.catalog import OffTheShelf, load_cameras
from tacos_framework.contracts import TaskBase, optional
from tacos_framework.errors import UserError, did_you_mean
from tacos_framework.plan.component import ConfiguredComponent
from tacos_framework.plan.findings import RecipeFindings
from tacos_framework.plan.rig import part_class, stand_ins
from tacos_framework.recipe import NamedScenario, Recipe, Weighted
from tacos_framework.settings import check


def check_scenarios(findings: RecipeFindings) -> None:
    """Several scenarios are told apart by name."""
    recipe = findings.recipe
    if not recipe.scenarios:
        findings.add(("scenario",), "the list of scenarios is empty", "a scenario, or several")
    names = [scenario.name for scenario in recipe.scenarios if isinstance(scenario, NamedScenario)]
    for i, name in enumerate(names):
        if name in names[:i]:
            findings.add(("scenario", i), f"two scenarios are called {name!r}", "a name for each")


def check_scores(findings: RecipeFindings, nodes: Mapping[str, ConfiguredComponent]) -> None:
    """The fitness takes scores that tasks report, each once."""
    recipe = findings.recipe
    scores = scores_of(nodes)
    if recipe.fitness and not any(term.weight for term in recipe.fitness):
        findings.add(
            ("fitness",), "all weights are 0, so that all cameras are equal", "a weight other than 0"
        )
    seen: set[str] = set()
    for i, term in enumerate(recipe.fitness):
        path = ("fitness", i, "score")
        if term.score in seen:
            findings.add(path, f"{term.score} stands twice", "each score once")
        seen.add(term.score)
        if term.score not in scores and _could_exist(term, recipe, nodes):
            remedy = did_you_mean(term.score, scores)
            findings.add(path, f"no task reports {term.score!r}", "node.score", remedy)


def check_margins(findings: RecipeFindings) -> None:
    """Every margin has to belong to a score of the fitness."""
    recipe = findings.recipe
    taken = [term.score for term in recipe.fitness]
    for score in recipe.test.margins if recipe.test else ():
        if score not in taken:
            remedy = did_you_mean(score, taken)
            findings.add(
                ("test", "margins", score),
                f"the fitness does not take {score!r}",
                "one of its scores",
                remedy,
            )


def declared_margins(nodes: Mapping[str, ConfiguredComponent]) -> dict[str, float]:
    """Differences of scores that do not matter, as tasks declare them, by ``node.score``."""
    return {
        f"{name}.{score}": margin
        for name, part in nodes.items()
        for score, margin in optional(part.cls, TaskBase, "margins").items()
    }


def scores_of(nodes: Mapping[str, ConfiguredComponent]) -> set[str]:
    return {f"{name}.{score}" for name, part in nodes.items() for score in getattr(part.cls, "scores", ())}


def _could_exist(term: Weighted, recipe: Recipe, nodes: Mapping[str, ConfiguredComponent]) -> bool:
    """False where the score's node is at fault already."""
    node = term.score.partition(".")[0]
    return node in nodes or node not in recipe.nodes


def find_cameras(findings: RecipeFindings, rig: ConfiguredComponent | None) -> tuple[OffTheShelf, ...]:
    """The cameras off the shelf that the design is compared with."""
    compare = findings.recipe.compare
    if compare is None or rig is None:
        return ()
    path = ("compare", "cameras")
    try:
        cameras = load_cameras(
            compare.cameras, compare.catalog, folder=findings.recipe.folder_of(("compare", "catalog"))
        )
    except UserError as error:
        findings.adopt(path, error)
        return ()
    for camera in cameras:
        given = {*camera.fixes, *findings.recipe.keys_of("design"), *findings.recipe.rig.settings}
        given |= stand_ins(rig, given)
        for name, info in rig.cls.Variables.model_fields.items():
            if info.is_required() and name not in given:
                what = f"camera {camera.name!r} says no {name!r}, and nor does the recipe"
                findings.add(path, what, info.description or "", "Give it under rig:, or compare another.")
        for name in camera.fixes:
            if name not in rig.cls.Variables.model_fields:
                findings.add(
                    path,
                    f"camera {camera.name!r} fixes {name!r}, which {rig.use} does not have",
                    "",
                    "Compare cameras made for this rig.",
                )
            elif kind := part_class(rig, name):
                for fault in check(kind, camera.fixes[name], str)[1]:
                    what = f"camera {camera.name!r} cannot be simulated: {fault.what}"
                    findings.add(
                        path, what, fault.expected, "Compare another, or state it in a catalog of yours."
                    )
    return tuple(cameras)
