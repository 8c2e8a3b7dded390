"""The exposure control of a recipe, and whether its renderer can do with it."""

from __future__ import annotations

from collections.abc import Mapping

from tacos_framework.contracts import RendererBase, optional
from tacos_framework.plan.component import ConfiguredComponent
from tacos_framework.plan.findings import RecipeFindings
from tacos_framework.plan.starting import with_starting_values
from tacos_framework.plan.targets import EXPOSURE


def find_exposure(
    findings: RecipeFindings, nodes: Mapping[str, ConfiguredComponent]
) -> ConfiguredComponent | None:
    """The control of the exposure; None if the exposure is fixed, or at fault."""
    use = findings.recipe.exposure
    if use is None:
        return None
    for name, part in nodes.items():
        if part.use.startswith("renderer.") and optional(part.instance, RendererBase, "averages_exposure"):
            findings.add(
                ("nodes", name),
                f"{part.use} averages light over the exposure time, which {use.use} sets only later",
                "a renderer of single moments",
                "Render single moments; an effect of motion blur follows the controlled exposure.",
            )
    cls = findings.component(use.use, "control", (EXPOSURE,))
    if cls is None:
        return None
    settings = with_starting_values(findings.recipe, EXPOSURE, EXPOSURE, cls, use.settings)
    return findings.configured(cls, use.use, settings, (EXPOSURE,))
