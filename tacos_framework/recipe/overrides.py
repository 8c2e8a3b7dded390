"""Values put into a recipe from outside its file: ``--set`` and ``--with``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from tacos_framework.errors import Fault
from tacos_framework.recipe.fixing import fix_variable
from tacos_framework.settings.yaml_document import Document

Path = tuple[str | int, ...]

_OF_A_VARIABLE = frozenset({"between", "integer", "choose", "from", "scheme", "columns", "distance"})
"""The keys an entry of ``design:`` may have."""

_OF_BOUNDS = frozenset({"min", "max", "is", "any_of", "unknown"})
"""The keys an entry of ``constraints:`` may have."""


def with_overrides(
    document: Document,
    sets: Mapping[str, Any],
    effects: Sequence[Mapping[str, Any]],
    places: Mapping[Path, str] = MappingProxyType({}),
) -> tuple[Document, list[Fault]]:
    """The document of a recipe with values set and effects added.

    - `document`: a recipe; a mapping. Its data is changed.
    - `sets`: dotted keys such as ``nodes.world.frames`` or ``fitness.0.weight``, and the values to put there.
      A plain value for a design variable, ``design.pitch_deg``, fixes it.
    - `effects`: effects to add to its ``effects:``.
    - `places`: where entries of these stand, by the number of the effect and the path below it.

    Returns: the document, which names the option where a value came from one, and faults of the keys.
    """
    data = document.data
    faults: list[Fault] = []
    elsewhere: dict[Path, str] = {}
    for dotted, value in sets.items():
        paths, found = _set(data, dotted, deepcopy(value))  # a later key may set what is within it
        faults += found
        for path in paths:
            stale = [known for known in elsewhere if known[: len(path)] == path]
            for known in stale:
                del elsewhere[known]
            elsewhere[path] = f"--set {dotted}"
    own = data.get("effects") or []
    if effects and isinstance(own, list):
        data["effects"] = [*own, *deepcopy(effects)]
        elsewhere |= {("effects", len(own) + i): f"added effect {i + 1}" for i in range(len(effects))}
        elsewhere |= {("effects", len(own) + int(i), *below): at for (i, *below), at in places.items()}
    unread = frozenset(
        path for path in document.unread if not any(path[: len(given)] == given for given in elsewhere)
    )
    return replace(document, elsewhere=elsewhere, unread=unread), faults


def _set(data: dict[str, Any], dotted: str, value: Any) -> tuple[list[Path], list[Fault]]:
    """Put `value` at a dotted key; where that is."""
    where = f"--set {dotted}"
    steps = dotted.split(".")
    if not all(steps):
        return [], [Fault(where, "an empty key", "names joined by dots, such as optimizer.generations")]
    if steps[0] == "design" and len(steps) > 1 and isinstance(data.get("design"), dict):
        name, below = _dotted_name(steps[1:], data["design"], _OF_A_VARIABLE)
        if not below and not isinstance(value, dict):
            return fix_variable(data, name, value, where)
        steps = ["design", name, *below]
    elif steps[0] == "constraints" and len(steps) > 1:
        bounded = data.get("constraints")
        name, below = _dotted_name(steps[1:], bounded if isinstance(bounded, dict) else {}, _OF_BOUNDS)
        steps = ["constraints", name, *below]
    target: Any = data
    path: list[str | int] = []
    for step in steps[:-1]:
        if isinstance(target, dict):
            if target.get(step) is None:  # absent, or a key with nothing behind it
                target[step] = {}
            target = target[step]
            path.append(step)
        elif _is_index(target, step):
            target = target[int(step)]
            path.append(int(step))
        else:
            return [], [Fault(where, f"there is nothing below {step!r}", "a mapping")]
    last = steps[-1]
    if isinstance(target, dict):
        target[last] = value
        return [(*path, last)], []
    if _is_index(target, last):
        target[int(last)] = value
        return [(*path, int(last))], []
    return [], [Fault(where, f"cannot be set: {'.'.join(steps[:-1])!r} is not a mapping", "a mapping")]


def _dotted_name(
    steps: Sequence[str], known: Mapping[str, Any], keys: frozenset[str]
) -> tuple[str, list[str]]:
    """The name that steps lead to, which may have dots itself, and what follows: names known come first."""
    for length in range(len(steps), 0, -1):
        if (name := ".".join(steps[:length])) in known:
            return name, list(steps[length:])
    if len(steps) > 1 and steps[-1] in keys:
        return ".".join(steps[:-1]), [steps[-1]]
    return ".".join(steps), []


def _is_index(target: Any, step: str) -> bool:
    return isinstance(target, list) and step.isdecimal() and int(step) < len(target)
