"""``--explain``: what a recipe comes down to."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from tacos_framework.contracts import LIGHT_STAGES, STAGES, acts_after_noise
from tacos_framework.plan import EXPOSURE, EffectPart, Plan
from tacos_framework.plan.procedure import ProcedurePlan
from tacos_framework.recipe import NamedScenario


def explain(plan: Plan) -> str:
    """The resolved graph, effective settings, where effects act, what each design variable reaches."""
    sections = (_graph, _effects, _scenarios, _exposure, _variables, _scored_by)
    return "\n\n".join("\n".join(section(plan)) for section in sections)


def explain_procedure(plan: ProcedurePlan) -> str:
    """The effective settings of a procedure."""
    return "\n".join(
        [plan.recipe.use, *_settings(plan.config), f"  {plan.executor}", *_settings(plan.executor_config)]
    )


def _graph(plan: Plan) -> Iterator[str]:
    yield "Graph, in the order of evaluation"
    for name in plan.graph.order:
        node = plan.graph.nodes[name]
        wiring = ", ".join(f"{port} from {source}" for port, source in node.sources.items())
        yield f"  {name}: {node.use}" + (f" ({wiring})" if wiring else "")
        part = plan.nodes[name]
        yield from _settings(part.config, _designed(plan, "node", name))
        if isinstance(part, EffectPart) and part.cameras is not None:
            yield f"      cameras: {', '.join(part.cameras)}"
    yield f"  rig: {plan.rig.use}"
    yield from _settings(plan.rig.config)
    for part in (plan.optimizer, plan.executor):
        yield f"  {part.use}"
        yield from _settings(part.config)


def _designed(plan: Plan, kind: str, owner: str) -> frozenset[str]:
    """The settings of a node or effect that are design variables, for all cameras."""
    targets = map(plan.target, plan.space.names)
    return frozenset(t.setting for t in targets if (t.kind, t.owner, t.camera) == (kind, owner, None))


def _settings(config: Any, designed: Collection[str] = ()) -> Iterator[str]:
    for name, field in type(config).model_fields.items():
        value = getattr(config, name)
        extra = field.json_schema_extra
        unit = extra.get("unit", "1") if isinstance(extra, dict) else "1"
        if name in designed:
            yield f"      {name}: designed"
            continue
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

    for part in plan.effects:
        cameras = "" if part.cameras is None else f", on {', '.join(part.cameras)}"
        yield f"  {part.name}: {part.use}{cameras}"
        yield from _settings(part.config, _designed(plan, "effect", part.name))


def _scenarios(plan: Plan) -> Iterator[str]:
    scenarios = plan.recipe.scenarios
    if len(scenarios) == 1:
        yield "Scenario"
    else:
        how = "the worst counts" if plan.fitness.over == "worst" else "their weighted mean counts"
        yield f"Scenarios: every candidate is scored in each, and {how}"
    for scenario in scenarios:
        if isinstance(scenario, NamedScenario):
            yield f"  {scenario.name}"
        yield from (line for line in _settings(scenario) if not line.startswith("      name: "))


def _exposure(plan: Plan) -> Iterator[str]:
    if plan.exposure is None:
        yield "Exposure: fixed"
        return
    yield f"Exposure: each camera sets its own from frame to frame, by {plan.exposure.use}"
    yield from _settings(plan.exposure.config, _designed(plan, EXPOSURE, EXPOSURE))


def _variables(plan: Plan) -> Iterator[str]:
    yield "Design variables"
    for variable in plan.space.variables:
        reached = ", ".join(plan.graph.reached_from(_readers(plan, variable.name)))
        sets = _what_it_sets(plan, variable.name)
        yield f"  {_described(variable.as_data())};{f' sets {sets};' if sets else ''} reaches {reached}"
    for name, value in plan.fixed.items():
        yield f"  {name} = {value}, fixed"


def _what_it_sets(plan: Plan, variable: str) -> str:
    """The target of a design variable in words; empty for a variable of the rig, whose name says it."""
    target = plan.target(variable)
    if target.kind == "rig":
        return ""
    if target.kind == "scenario":
        several = len(plan.recipe.scenarios) > 1
        whose = f"scenario {target.owner}" if target.owner else "all scenarios" if several else "the scenario"
        return f"{target.setting} of {whose}"
    if plan.exposure is not None and target.kind == EXPOSURE:
        return f"{target.setting} of the exposure control ({plan.exposure.use})"
    effects = {part.name: part for part in plan.effects}
    part = plan.nodes[target.owner] if target.kind == "node" else effects[target.owner]
    camera = f" at camera {target.camera}" if target.camera else ""
    return f"{target.setting} of {target.kind} {target.owner} ({part.use}){camera}"


def _readers(plan: Plan, variable: str) -> list[str]:
    """The nodes that read a design variable at first hand; what they feed depends on it through them."""
    target = plan.target(variable)
    if target.kind == "node":
        return [target.owner]
    if target.kind == "effect":
        (part,) = [part for part in plan.effects if part.name == target.owner]
        return list(plan.graph.of_kind("renderer" if part.cls.stage in LIGHT_STAGES else "sensor"))
    if target.kind == EXPOSURE:
        return list(plan.graph.of_kind("sensor"))
    asked = "rig"
    if target.kind == "scenario":
        asked = "illumination_lux" if target.setting == "illumination_lux" else "exposure"
    return [name for name in plan.graph.order if asked in plan.graph.nodes[name].signature.supplied]


def _described(variable: Mapping[str, Any]) -> str:
    name = variable["name"]
    unit = f" {variable['unit']}" if variable["unit"] not in ("", "1") else ""
    if variable["kind"] == "catalog":
        return f"{name}: one of {variable['values']} parts of {variable['catalog']}, {variable['scheme']}"
    if variable["kind"] == "categorical":
        return f"{name}: one of {', '.join(map(str, variable['values']))}"
    return f"{name}: {variable['kind']}, {variable['lower']:g} to {variable['upper']:g}{unit}"


def _scored_by(plan: Plan) -> Iterator[str]:
    yield "Scored by"
    for term in plan.recipe.fitness:
        yield f"  {term.weight:g} x {term.score}"
    for constraint in plan.constraints:
        limits = [f">= {constraint.min:g}"] if constraint.min is not None else []
        limits += [f"<= {constraint.max:g}"] if constraint.max is not None else []
        limits += [f"is {' or '.join(constraint.any_of)}"] if constraint.any_of else []
        unit = plan.rig.cls.derived_quantities.get(constraint.quantity, "").removeprefix("1")
        yield f"  only where {constraint.quantity} {' and '.join(limits)} {unit}".rstrip()
    for objective in plan.objectives:
        yield f"  a front of {objective.name}, {objective.aim}"
    for camera in plan.cameras:
        yield f"  beside {camera.name}: {camera.title}"
