"""The effects of a recipe: what they are called, and which cameras have them."""

from __future__ import annotations

from tacos_framework.contracts import formation_order
from tacos_framework.plan.component import EffectPart
from tacos_framework.plan.findings import RecipeFindings
from tacos_framework.plan.starting import with_starting_values


def find_effects(findings: RecipeFindings) -> dict[str, EffectPart]:
    """The sound effects by name, in the order of image formation."""
    recipe = findings.recipe
    names = recipe.effect_names
    found = {}
    for i, (name, use) in enumerate(zip(names, recipe.effects, strict=True)):
        path = ("effects", i)
        if name in names[:i]:
            findings.add((*path, "name"), f"two effects are called {name!r}", "a name for each")
        cls = findings.component(use.use, "effect", path)
        if cls is None:
            continue
        settings = with_starting_values(recipe, "effect", name, cls, use.settings)
        if (part := findings.configured(cls, use.use, settings, path)) and name not in found:
            found[name] = EffectPart(
                part.use, part.cls, part.config, part.distribution, part.built, name, use.cameras
            )
    return {part.name: part for part in sorted(found.values(), key=lambda part: formation_order(part.cls))}
