"""The effects of a recipe: what they are called, and which cameras have them."""

from __future__ import annotations

from collections.abc import Mapping

from tacos_framework.contracts import FILE_STAGES, EffectBase, TaskBase, formation_order, optional
from tacos_framework.graph import Graph
from tacos_framework.plan.component import ConfiguredComponent, EffectPart
from tacos_framework.plan.findings import RecipeFindings
from tacos_framework.plan.starting import with_starting_values
from tacos_framework.settings import KeyPath


def check_wanted_files(
    findings: RecipeFindings,
    graph: Graph,
    nodes: Mapping[str, ConfiguredComponent],
    effects: Mapping[str, EffectPart],
) -> None:
    """Tasks that want linear files must get them: what is coded cannot be made linear again."""
    coding = [part.name for part in effects.values() if _codes(part)]
    for task in graph.of_kind("task"):
        part = nodes[task]
        if optional(part.instance, TaskBase, "wants") != "linear":
            continue
        upstream = (nodes[name] for name in graph.leading_to(task))
        found = [*coding, *(each.name for each in upstream if isinstance(each, EffectPart) and _codes(each))]
        if found:
            what = f"{part.use} wants linear files, and {', '.join(found)} codes them for a display"
            remedy = f"Take {'it' if len(found) == 1 else 'them'} out of the recipe, or set pipeline: raw."
            findings.add(("nodes", task), what, "linear files", remedy)


def _codes(part: EffectPart) -> bool:
    return bool(optional(part.instance, EffectBase, "codes"))


def find_effects(findings: RecipeFindings) -> dict[str, EffectPart]:
    """The sound effects by name, in the order of image formation."""
    recipe = findings.recipe
    names = recipe.effect_names
    found = {}
    for i, (name, use) in enumerate(zip(names, recipe.all_effects, strict=True)):
        processes = i >= len(recipe.effects)
        path: KeyPath = ("pipeline", use.use.partition(".")[2]) if processes else ("effects", i)
        if name in names[:i]:
            findings.add((*path, "name"), f"two effects are called {name!r}", "a name for each")
        cls = findings.component(use.use, "effect", path)
        if cls is None:
            continue
        if processes and cls.stage not in FILE_STAGES:
            what = f"{use.use} acts in the stage {cls.stage}, before there are files"
            findings.add(
                path, what, f"an effect of the stages {' and '.join(FILE_STAGES)}", "Put it under effects:."
            )
        settings = with_starting_values(recipe, "effect", name, cls, use.settings)
        if (part := findings.configured(cls, use.use, settings, path)) and name not in found:
            found[name] = EffectPart(
                part.use, part.cls, part.config, part.distribution, part.built, name, use.cameras
            )
    return {part.name: part for part in sorted(found.values(), key=lambda part: formation_order(part.cls))}
