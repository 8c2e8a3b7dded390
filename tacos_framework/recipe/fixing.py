"""A design variable fixed from outside the recipe: it leaves ``design:`` for where its value stands."""

from __future__ import annotations

from typing import Any

from tacos_framework.errors import Fault
from tacos_framework.recipe.effect_names import find_effect

Path = tuple[str | int, ...]


def fix_variable(data: dict[str, Any], name: str, value: Any, where: str) -> tuple[list[Path], list[Fault]]:
    """Fix a variable of a recipe's plain data, which is changed.

    - `data`: the recipe; its ``design`` is a mapping.
    - `name`: ``pitch_deg``, ``isp.gamma``, ``effects.jpeg.quality``, ``scenario.gain_db``,
      ``exposure.target``.
    - `where`: what to call the place in faults.

    Returns: where the value stands now. A variable that has no place of its own, as a setting of one camera,
    stays under ``design:``, with nothing to choose from but the value.
    """
    design = data["design"]
    if not [other for other in design if other != name]:
        return [], [
            Fault(
                where,
                f"with {name!r} fixed, nothing is left to design",
                "at least one design variable",
                "Fix it together with designing another, or leave it free.",
            )
        ]
    places = _places(data, name)
    if not places:
        design[name] = {"choose": [value]}
        return [("design", name)], []
    design.pop(name, None)
    for *above, last in places:
        target: Any = data
        for step in above:
            target = target[step]
        target[last] = value
    return places, []


def _places(data: dict[str, Any], name: str) -> list[Path]:
    """Positions of a variable's values outside of ``design:``; none where it has no such place."""
    head, _, rest = name.partition(".")
    if not rest:
        return [("rig", name)] if isinstance(data.get("rig"), dict) else []
    if head == "scenario":
        return _in_scenarios(data, rest)
    if head == "exposure":
        return [("exposure", rest)] if isinstance(data.get("exposure"), dict) else []
    owner, _, setting = rest.rpartition(".")
    if head == "effects":
        effects = data.get("effects")
        index = find_effect(effects, owner) if isinstance(effects, list) else None
        return [] if index is None else [("effects", index, setting)]
    nodes = data.get("nodes")
    found = isinstance(nodes, dict) and isinstance(nodes.get(head), dict) and not owner
    return [("nodes", head, setting)] if found else []


def _in_scenarios(data: dict[str, Any], rest: str) -> list[Path]:
    """Positions of a setting of the scenario: in the only one, in one of several, or in all of them."""
    if data.get("scenario") is None:
        data["scenario"] = {}
    scenarios = data["scenario"]
    name, _, key = rest.rpartition(".")
    if isinstance(scenarios, dict):
        return [] if name else [("scenario", key)]
    if not isinstance(scenarios, list):
        return []
    known = [(i, each) for i, each in enumerate(scenarios) if isinstance(each, dict)]
    return [("scenario", i, key) for i, each in known if not name or each.get("name") == name]
