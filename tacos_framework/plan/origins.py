"""Origins of the figures that sensors and effects simulate parts with: known of the part, or assumed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping

from tacos_framework.catalog import in_words
from tacos_framework.contracts import SensorBase, optional
from tacos_framework.plan.component import ConfiguredComponent
from tacos_framework.plan.feasibility import derived_of
from tacos_framework.plan.notes import middle
from tacos_framework.plan.plan import Plan
from tacos_framework.variables.design_space import CatalogChoice

_ASSUMED = "assumed"
"""How the origin of an assumed figure begins."""


def says_origins(component: ConfiguredComponent) -> bool:
    return callable(optional(component.cls, SensorBase, "origins"))


def origins_of_parts(
    plan: Plan, component: ConfiguredComponent, choice: CatalogChoice
) -> Iterator[tuple[str, Mapping[str, str]]]:
    """Names of parts, each with the origin of each figure of it, as `SensorBase.origins`.

    Parts that are no image sensor of a camera are left out.
    """
    others = middle(plan)
    for row in choice.rows:
        part = row.as_dict()
        values = {**others, choice.name: part}
        if derived_of(plan, values) is None:
            continue
        with plan.rig.calling("build"):
            rig = plan.rig.instance.build(plan.rig_variables(values))
        for camera in rig.cameras:
            if camera.electrons.sensor == (part.get("sensor") or row.name):  # of a product, or itself one
                with component.calling("origins"):
                    yield row.name, dict(component.instance.origins(camera))
                break


def notes_on_assumptions(plan: Plan) -> Iterator[str]:
    """Of each sensor model and effect, how many parts it assumes a figure of, and which figures."""
    components = [*plan.nodes.values(), *plan.effects]
    for component in filter(says_origins, components):
        for choice in plan.space.variables:
            if not isinstance(choice, CatalogChoice):
                continue
            assumed: Counter[str] = Counter()
            parts, of_parts = 0, 0
            for _, origins in origins_of_parts(plan, component, choice):
                figures = [figure for figure, origin in origins.items() if origin.startswith(_ASSUMED)]
                assumed.update(figures)
                parts, of_parts = parts + 1, of_parts + bool(figures)
            if assumed:
                named = ", ".join(f"{in_words(figure)} ({n})" for figure, n in assumed.most_common())
                yield (
                    f"{component.use} assumes figures of {of_parts} of {parts} parts of "
                    f"{choice.catalog.name}: {named}."
                )
