"""``--explain``: what a recipe comes down to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from tacos_framework.contracts import STAGES, acts_after_noise
from tacos_framework.plan import Plan
from tacos_framework.plan.procedure import ProcedurePlan


def explain(plan: Plan) -> str:
    """The resolved graph, effective settings, where effects act, what each design variable reaches."""
    return "\n".join([*_graph(plan), "", *_effects(plan), "", *_variables(plan), "", *_judged(plan)])


def explain_procedure(plan: ProcedurePlan) -> str:
    """The effective settings of a procedure."""
    executor = plan.recipe.executor.use
    return "\n".join(
        [plan.recipe.use, *_settings(plan.config), f"  {executor}", *_settings(plan.executor_config)]
    )


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
        shown = "-" if value is None or value == "" else f"{value}{'' if unit == '1' else f' {unit}'}"
        yield f"      {name}: {shown}{given}"


def _effects(plan: Plan) -> Iterator[str]:
    yield "Image formation"
    for stage in STAGES:
        here = [part for part in plan.effects if part.cls.stage == stage]
        late = [part.use for part in here if stage == "pixel" and acts_after_noise(part.cls)]
        yield f"  {stage}: {', '.join(part.use for part in here if part.use not in late) or '-'}"
        if stage == "pixel":
            yield "  (noise)"
        if late:
            yield f"  {stage}, after the noise: {', '.join(late)}"


def _variables(plan: Plan) -> Iterator[str]:
    yield "Design variables"
    for variable in plan.space.variables:
        reached = ", ".join(plan.graph.reached_from(_readers(plan, variable.name)))
        yield f"  {_described(variable.as_data())}; reaches {reached}"
    for name, value in plan.fixed.items():
        yield f"  {name} = {value}, fixed"


def _readers(plan: Plan, variable: str) -> list[str]:
    """The nodes that read a design variable at first hand; what they feed depends on it through them."""
    node, _, setting = variable.partition(".")
    if setting and node != "scenario":
        return [node]
    asked = {"exposure", "illumination_lux"} if setting else {"rig"}
    return [name for name in plan.graph.order if asked & plan.graph.nodes[name].signature.supplied]


def _described(variable: Mapping[str, Any]) -> str:
    """One design variable in a line, from its `as_data`."""
    name, unit = variable["name"], variable["unit"]
    if variable["kind"] == "catalog":
        return f"{name}: one of {variable['values']} parts of {variable['catalog']}, {variable['scheme']}"
    if variable["kind"] == "categorical":
        return f"{name}: one of {', '.join(map(str, variable['values']))}"
    return f"{name}: {variable['kind']}, {variable['lower']:g} to {variable['upper']:g} {unit}"


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
