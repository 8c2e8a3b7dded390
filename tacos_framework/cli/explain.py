"""``--explain``: what a recipe comes down to."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from tacos_framework.plan import STAGES, Plan


def explain(plan: Plan) -> str:
    """The resolved graph, effective settings, where effects act, what each design variable reaches."""
    return "\n".join([*_graph(plan), "", *_effects(plan), "", *_variables(plan), "", *_judged(plan)])


def _graph(plan: Plan) -> Iterator[str]:
    yield "Graph, in the order of evaluation"
    for name in plan.graph.order:
        node = plan.graph.nodes[name]
        wiring = ", ".join(f"{port} from {source}" for port, source in node.sources.items())
        yield f"  {name}: {node.use}" + (f" ({wiring})" if wiring else "")
        yield from _settings(plan.nodes[name].config)
    yield f"  rig: {plan.rig.use}"
    yield from _settings(plan.rig.config)
    for part in (plan.optimizer, plan.executor):
        yield f"  {part.use}"
        yield from _settings(part.config)


def _settings(config: Any) -> Iterator[str]:
    for name, field in type(config).model_fields.items():
        value = getattr(config, name)
        extra = field.json_schema_extra
        unit = extra.get("unit", "1") if isinstance(extra, dict) else "1"
        given = "" if name in config.model_fields_set else "  (default)"
        yield f"      {name}: {value}{'' if unit == '1' else f' {unit}'}{given}"


def _effects(plan: Plan) -> Iterator[str]:
    yield "Image formation"
    for stage in STAGES:
        here = [part.use for part in plan.effects if part.cls.stage == stage]
        yield f"  {stage}: {', '.join(here) or '-'}"
        if stage == "pixel":
            yield "  (noise)"


def _variables(plan: Plan) -> Iterator[str]:
    yield "Design variables"
    takes_rig = [name for name in plan.graph.order if "rig" in plan.graph.nodes[name].signature.supplied]
    for variable in plan.space.variables:
        node, _, setting = variable.name.partition(".")
        readers = takes_rig
        if setting:
            readers = (
                [node]
                if node != "scenario"
                else [
                    name
                    for name in plan.graph.order
                    if {"exposure", "illumination_lux"} & plan.graph.nodes[name].signature.supplied
                ]
            )
        yield f"  {variable.describe()}; read by {', '.join(readers)}"
    for name, value in plan.fixed.items():
        yield f"  {name} = {value} (fixed); read by {', '.join(takes_rig)}"


def _judged(plan: Plan) -> Iterator[str]:
    yield "Judged by"
    for term in plan.recipe.fitness:
        yield f"  {term.weight:g} x {term.score}"
    for name, bounds in plan.recipe.constraints.items():
        limits = [f">= {bounds.min:g}"] if bounds.min is not None else []
        limits += [f"<= {bounds.max:g}"] if bounds.max is not None else []
        yield f"  only where {name} {' and '.join(limits)} {plan.rig.cls.derived_quantities[name]}"
    for camera in plan.cameras:
        yield f"  beside {camera.name}: {camera.title}"
