"""What a study simulates, in a sentence: light, exposure, motion and other effects, and whose noise."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from tacos_framework.contracts import SensorBase, optional
from tacos_framework.plan.feasibility import derived_of
from tacos_framework.plan.plan import Plan
from tacos_framework.recipe import NamedScenario, Scenario
from tacos_framework.variables.design_space import CatalogChoice

STATED = ("catalog", "settings")
"""Origins of figures of noise that belong to the part itself; see `SensorBase.origins`."""


def conditions(plan: Plan) -> str:
    """For readers of results, before they read a number."""
    designed = [name.rpartition(".")[2] for name in plan.space.names if name.startswith("scenario")]
    light = "; ".join(_scenario_words(each, designed) for each in plan.recipe.scenarios)
    if plan.exposure is not None:
        light += f", from which {plan.exposure.use} sets time and gain"
    effects = [*plan.effects, *(node for node in plan.nodes.values() if node.use.startswith("effect."))]
    said = [_effect_words(effect.use, effect.config.model_dump(exclude_unset=True)) for effect in effects]
    formed = f"effects of the camera: {', '.join(said)}" if said else "no effects beyond noise"
    return f"Simulated: {light}; {formed}{''.join(_noise_words(plan))}."


def _scenario_words(scenario: Scenario, designed: list[str]) -> str:
    values = {
        "illumination_lux": f"{scenario.illumination_lux:g} lux",
        "exposure_ms": f"{scenario.exposure_ms:g} ms",
        "f_number": f"f/{scenario.f_number:g}",
        "gain_db": f"{scenario.gain_db:g} dB",
    }
    shown = (f"{name} as designed" if name in designed else words for name, words in values.items())
    called = f"{scenario.name}: " if isinstance(scenario, NamedScenario) else ""
    return called + ", ".join(shown)


def _effect_words(use: str, settings: Mapping[str, Any]) -> str:
    given = ", ".join(f"{key} {value}" for key, value in settings.items() if value is not None)
    return f"{use.partition('.')[2]}{f' ({given})' if given else ''}"


def _noise_words(plan: Plan) -> Iterator[str]:
    """Of each sensor model that says where its figures come from: of how many parts they are assumed."""
    for node in plan.nodes.values():
        if not callable(optional(node.cls, SensorBase, "origins")):
            continue
        for variable in plan.space.variables:
            if isinstance(variable, CatalogChoice):
                assumed = sum(_is_assumed(plan, node.instance, variable, row) for row in variable.rows)
                parts = f"{assumed} of {len(variable.rows)} parts"
                yield f"; noise by {node.use}, with figures assumed for {parts}"


def _is_assumed(plan: Plan, sensor: Any, variable: CatalogChoice, part: Any) -> bool:
    """Whether a figure of the noise of a part is not its own; parts that make no camera have none."""
    middle = plan.space.decode([(gene.lower + gene.upper) / 2 for gene in plan.space.genes]).as_dict()
    values = {**middle, variable.name: part.as_dict()}
    if derived_of(plan, values) is None:
        return False
    try:
        rig = plan.rig.instance.build(plan.rig_variables(values))
        origins = [sensor.origins(camera) for camera in rig.cameras]
    except Exception:  # noqa: BLE001 - a remark must not cost a study its results
        return False
    return any(origin not in STATED for each in origins for origin in each.values())
