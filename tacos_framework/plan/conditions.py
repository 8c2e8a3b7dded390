"""Conditions that a study simulates, in a sentence: light, exposure, motion, effects, and whose noise."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from tacos_framework.contracts import SceneBase, optional
from tacos_framework.plan.notes import catalog_choices
from tacos_framework.plan.origins import assumed_figures, cameras_of_parts, says_origins
from tacos_framework.plan.plan import Plan
from tacos_framework.recipe import NamedScenario, Scenario


def conditions(plan: Plan) -> str:
    """For readers of results, before they read a number."""
    designed = [name.rpartition(".")[2] for name in plan.space.names if name.startswith("scenario")]
    light = "; ".join(_scenario_words(each, designed) for each in plan.recipe.scenarios)
    if plan.exposure is not None:
        light += f", from which {plan.exposure.use} sets time and gain"
    scenes = [node for node in plan.nodes.values() if node.use.startswith("scene.")]
    moved = [optional(node.instance, SceneBase, "moves") for node in scenes]
    light += "".join(f"; moving at {words}" for words in moved if words)
    effects = [*plan.effects, *(node for node in plan.nodes.values() if node.use.startswith("effect."))]
    said = [_effect_words(effect.use, effect.config.model_dump(exclude_unset=True)) for effect in effects]
    formed = f"effects of the camera: {', '.join(said)}" if said else "no effects beyond noise"
    return f"Simulated: {light}; {formed}{''.join(_noise_words(plan))}."


def _scenario_words(scenario: Scenario, designed: list[str]) -> str:
    values = {
        "illumination_lux": ("light", f"{scenario.illumination_lux:g} lux"),
        "exposure_ms": ("exposure time", f"{scenario.exposure_ms:g} ms"),
        "f_number": ("f-number", f"f/{scenario.f_number:g}"),
        "gain_db": ("gain", f"{scenario.gain_db:g} dB"),
    }
    shown = (f"{noun} as designed" if name in designed else value for name, (noun, value) in values.items())
    called = f"{scenario.name}: " if isinstance(scenario, NamedScenario) else ""
    return called + ", ".join(shown)


def _effect_words(use: str, settings: Mapping[str, Any]) -> str:
    given = ", ".join(f"{key} {value}" for key, value in settings.items() if value is not None)
    return f"{use.partition('.')[2]}{f' ({given})' if given else ''}"


def _noise_words(plan: Plan) -> Iterator[str]:
    """Of each sensor model that says where its figures come from: of how many parts they are assumed."""
    for node in filter(says_origins, plan.nodes.values()):
        counts = ""
        for choice in catalog_choices(plan):
            try:
                assumed = assumed_figures(node, cameras_of_parts(plan, choice))
            except Exception:  # noqa: BLE001 - a remark must not cost a study its results
                continue
            if assumed:
                counts = f", with figures assumed for {sum(map(bool, assumed))} of {len(assumed)} parts"
        yield f"; noise by {node.use}{counts}"
