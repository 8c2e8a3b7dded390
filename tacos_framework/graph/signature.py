"""The ports of a component: fixed by its kind, or read off the annotations of its verb."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, get_type_hints

from tacos_framework.contracts import FILE_STAGES
from tacos_framework.values import Capture, FrameBatch

NODE_KINDS = ("scene", "renderer", "effect", "sensor", "transform", "task")
"""The kinds that can be nodes."""

_VERB = {"scene": "episode", "renderer": "capture", "transform": "transform", "task": "begin"}
"""The kinds whose ports a verb's signature gives."""


@dataclass(frozen=True)
class Signature:
    """The ports of a component."""

    inputs: Mapping[str, Any]
    output: Any
    """Type of the output port; None for tasks, which end a path."""
    supplied: frozenset[str]
    """Keyword-only parameters of the verb, supplied by the framework."""
    verb: str = ""
    """The method that is called; none for those that the framework drives."""


def signature_of(cls: type[Any], kind: str) -> Signature:
    """The ports of a component class.

    Effects and sensors work on plain arrays, and the framework brings them to views and images: an effect
    that acts before digitisation takes and gives a `Capture`, one that acts on files a `FrameBatch`, and a
    sensor turns the one into the other.

    Raises `TypeError` when a port has no annotation, or a verb does not say what it gives. Raises `NameError`
    when an annotation names what cannot be found.
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
    elif output in (None, type(None)):
        raise TypeError(f"{cls.__name__}.{verb.__name__} is not annotated with what it returns")
    return Signature(inputs, output, supplied, _VERB[kind])


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
