"""Candidates beyond what a scene can show, as cameras that are finer than the one that recorded it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from tacos_framework.contracts import SceneBase, optional
from tacos_framework.plan import Plan
from tacos_framework.plan.feasibility import derived_of
from tacos_framework.randomness import generator
from tacos_framework.simulation.context import EvaluationContext

if TYPE_CHECKING:
    from tacos_framework.simulation.simulation import Simulation

_TRIES = 200
"""Cameras drawn from the design space to tell how much of it a recording answers for."""


def not_shown(contexts: Mapping[str, EvaluationContext]) -> dict[str, str]:
    """Why a candidate, in each of its scenarios, is not what the scenes can show.

    Returns: a word or two -> a sentence.
    """
    reasons: dict[str, str] = {}
    for context in contexts.values():
        graph = context.plan.graph
        for name in graph.of_kind("scene"):
            tells = optional(context.components[name], SceneBase, "not_shown")
            if not callable(tells):
                continue
            sensors = [
                context.components[s].sensor for s in graph.of_kind("sensor") if graph.scene_of(s) == name
            ]
            with context.plan.nodes[name].calling(f"not_shown in node {name!r}"):
                reasons |= tells(
                    context.rig,
                    exposure=context.exposure,
                    sensors=sensors,
                    illumination_lux=context.scenario.illumination_lux,
                )
    return reasons


def notes_on_shown(plan: Plan) -> Iterator[str]:
    """Share of the design space that recordings cover, and the reasons for the rest."""
    from tacos_framework.simulation.simulation import Simulation  # which asks this module of each candidate

    yield from _notes(plan, Simulation(plan))


def _notes(plan: Plan, simulation: Simulation) -> Iterator[str]:
    rng = generator(0, "shown")
    found = []
    for _ in range(_TRIES):
        values = plan.space.sample(rng).as_dict()
        derived = derived_of(plan, values)
        if derived is not None and not plan.breaches(values, derived):
            found.append(simulation.not_shown(values))
    if not found:
        return
    shown = sum(not reasons for reasons in found) / len(found)
    yield f"The recording answers for {shown:.0%} of {len(found)} cameras drawn from the design space."
    kinds = Counter(kind for reasons in found for kind in reasons)
    for kind, count in kinds.most_common():
        example = next(reasons[kind] for reasons in found if kind in reasons)
        yield f"Refused for {kind}: {count / len(found):.0%}; one of them: {example}."
