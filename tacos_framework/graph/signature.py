"""The ports of a component, read off the annotations of its verb."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, get_type_hints

from tacos_framework.contracts import FILE_STAGES
from tacos_framework.values import Capture, FrameBatch

_VERB = {"scene": "episode", "renderer": "capture", "task": "begin"}
"""The kinds that can be nodes, and the verb whose signature gives their ports."""


@dataclass(frozen=True)
class Signature:
    """The ports of a component, read off the annotations of its verb.

    Parameters
    ----------
    inputs
        Input ports and their types.
    output
        Type of the output port; None for tasks, which end a path.
    supplied
        Keyword-only parameters: what the framework supplies.
    verb
        The method that is called; none for those that the framework drives.
    """

    inputs: Mapping[str, type[Any]]
    output: type[Any] | None
    supplied: frozenset[str]
    verb: str = ""


def signature_of(cls: type[Any], kind: str) -> Signature:
    """The ports of a component class.

    Raises
    ------
    TypeError
        When a port has no annotation.
    """
    if kind == "sensor":
        return Signature({"capture": Capture}, FrameBatch, frozenset({"rig", "exposure"}))
    if kind == "effect":
        image = FrameBatch if cls.stage in FILE_STAGES else Capture
        port = "frames" if image is FrameBatch else "capture"
        return Signature({port: image}, image, frozenset({"rig", "exposure"}))
    verb = getattr(cls, _VERB[kind])
    inputs, output, supplied = _ports(verb, cls)
    if kind == "task":
        if output is None or not hasattr(output, "update"):
            raise TypeError(
                f"{cls.__name__}.begin is annotated to return {output}, which has no update method"
            )
        inputs, _, _ = _ports(output.update, output)
        output = None
    return Signature(inputs, output, supplied, verb.__name__)


def _ports(verb: Callable[..., Any], cls: type[Any]) -> tuple[dict[str, Any], Any, frozenset[str]]:
    hints = get_type_hints(verb)
    inputs, supplied = {}, set()
    for name, parameter in list(inspect.signature(verb).parameters.items())[1:]:
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY:
            supplied.add(name)
        elif name in hints:
            inputs[name] = hints[name]
        else:
            raise TypeError(f"{cls.__name__}.{verb.__name__}: port {name!r} has no type annotation")
    return inputs, hints.get("return"), frozenset(supplied)
