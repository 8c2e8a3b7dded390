"""Calls of the framework to each kind of component, and a check of the methods that receive them."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, get_type_hints

from tacos_framework.errors import did_you_mean

Parameters = list[inspect.Parameter]


@dataclass(frozen=True)
class Call:
    """One way in which the framework calls a component."""

    verb: str
    """The method; ``__init__`` for the class itself."""
    given: tuple[str, ...] | None = ()
    """Positional parameters, in order; None for input ports, of which there may be any number."""
    supplied: tuple[str, ...] = ()
    """Keywords the framework can supply."""
    asked_for: bool = False
    """True if a method is given only the keywords it asks for, rather than all of them."""
    offered: tuple[str, ...] = ()
    """Further keywords, of which a method is given those it names among its parameters."""

    def faults(self, cls: type[Any]) -> Iterator[str]:
        """Reasons why a class cannot be called so, in sentences."""
        method = getattr(cls, self.verb)
        try:
            parameters = [*inspect.signature(method).parameters.values()][_bound(cls, self.verb) :]
        except (TypeError, ValueError):  # what is written in C may not tell
            return
        name = cls.__name__ if self.verb == "__init__" else f"{cls.__name__}.{self.verb}"
        yield from self._keyword_faults(name, parameters)
        if self.verb == "__init__" and method is object.__init__:
            yield f"{name} has no __init__, so that it cannot be built with its settings"
        elif self.given is None:
            yield from self._port_faults(name, method, parameters)
        else:
            yield from self._position_faults(name, parameters, self.given)

    @property
    def _by_keyword(self) -> tuple[str, ...]:
        return (*self.supplied, *self.offered)

    def _keyword_faults(self, name: str, parameters: Parameters) -> Iterator[str]:
        alone = [p for p in parameters if p.kind is p.KEYWORD_ONLY]
        for parameter in alone:
            if parameter.default is parameter.empty and parameter.name not in self._by_keyword:
                supplied = ", ".join(self._by_keyword) or "nothing"
                yield (
                    f"{name} asks for {parameter.name!r}, which the framework does not supply: {supplied} "
                    f"can be had by keyword. {did_you_mean(parameter.name, self._by_keyword)}"
                ).rstrip()
        if self.asked_for or any(p.kind is p.VAR_KEYWORD for p in parameters):
            return
        accepted = {p.name for p in parameters if p.kind in (p.KEYWORD_ONLY, p.POSITIONAL_OR_KEYWORD)}
        for keyword in self.supplied:
            if keyword not in accepted:
                yield f"{name} does not take {keyword!r}, with which the framework calls it"

    def _position_faults(self, name: str, parameters: Parameters, given: tuple[str, ...]) -> Iterator[str]:
        if any(p.kind is p.VAR_POSITIONAL for p in parameters):
            return
        room = [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
        by_position = [p for p in room if p.name not in self._by_keyword]
        needed = [p for p in by_position if p.default is p.empty]
        if len(needed) > len(given):
            extra = ", ".join(repr(p.name) for p in needed[len(given) :])
            yield f"{name} needs {extra}, which it is not given: it is called with {_called(given)}"
        elif len(room) < len(given):
            yield f"{name} takes {len(room)} arguments by position, but is called with {_called(given)}"

    def _port_faults(self, name: str, method: Callable[..., Any], parameters: Parameters) -> Iterator[str]:
        try:
            hints = get_type_hints(method)
        except Exception as error:  # noqa: BLE001 - an annotation may name anything
            yield f"{name}: its annotations cannot be read: {type(error).__name__}: {error}"
            return
        for parameter in parameters:
            if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
                yield f"{name}: {parameter.name!r} stands for any ports; each needs a name and a type"
            elif parameter.kind is parameter.KEYWORD_ONLY:
                continue
            elif parameter.name in self.supplied:
                yield f"{name}: {parameter.name!r} is supplied by keyword, and no port: put it behind a *"
            elif parameter.name not in hints:
                yield f"{name}: port {parameter.name!r} has no type annotation"
        if self.asked_for and hints.get("return") in (None, type(None)):
            yield f"{name} does not say what it gives: annotate it with a type"


def _called(given: tuple[str, ...]) -> str:
    return ", ".join(given) or "no arguments by position"


def _bound(cls: type[Any], verb: str) -> int:
    """Number of parameters taken by the binding: ``self`` or ``cls``, but none of a static method's."""
    raw = inspect.getattr_static(cls, verb)
    return 0 if isinstance(raw, staticmethod | classmethod) else 1


def scorer_faults(task: type[Any]) -> Iterator[str]:
    """Faults of a task's scorer, as the annotation of ``begin`` has it."""
    name = f"{task.__name__}.begin"
    try:
        scorer = get_type_hints(task.begin).get("return")
    except Exception as error:  # noqa: BLE001 - as above
        yield f"{name}: its annotations cannot be read: {type(error).__name__}: {error}"
        return
    if not isinstance(scorer, type):
        yield f"{name} does not say what it returns: annotate it with the class of the scorer"
        return
    for verb in ("update", "scores"):
        if not callable(getattr(scorer, verb, None)):
            yield f"{name} is annotated to return {scorer.__name__}, which has no method {verb}"
    for call in (Call("update", given=None), Call("scores")):
        if callable(getattr(scorer, call.verb, None)):
            yield from call.faults(scorer)


_SCENARIO = ("rig", "exposure", "rng", "illumination_lux")
_SENSOR = ("camera", "exposure")
_CONFIG = Call("__init__", ("config",))

CALLS: Mapping[str, tuple[Call, ...]] = {
    "scene": (_CONFIG, Call("episode", None, ("rng", "illumination_lux"), asked_for=True)),
    "rig": (_CONFIG, Call("build", ("variables",)), Call("derived", ("variables",))),
    "renderer": (_CONFIG, Call("capture", None, _SCENARIO, asked_for=True)),
    "transform": (_CONFIG, Call("transform", None, (*_SCENARIO, "memory"), asked_for=True)),
    "effect": (_CONFIG, Call("on_array", ("samples",), ("geometry", "context", "rng"))),
    "sensor": (
        _CONFIG,
        Call("expect", ("light_cd_m2",), _SENSOR),
        Call("moments", ("samples_dn",), (*_SENSOR, "photon_scale")),
        Call("draw", ("samples_dn",), (*_SENSOR, "rng", "photon_scale")),
        Call("dn_per_electron", _SENSOR),
    ),
    "control": (_CONFIG, Call("adjust", ("frame_dn",), ("exposure", "context"))),
    "task": (_CONFIG, Call("begin", (), ("state",))),
    "trainable": (Call("initial_state", (), ("rng",)), Call("fit", ("batches",), ("state", "budget", "rng"))),
    "optimizer": (
        Call("__init__", ("config",), ("space", "rng"), offered=("problem",)),
        Call("ask"),
        Call("tell", ("evaluated",)),
        Call("stop"),
        Call("state"),
        Call("restore", ("state",)),
    ),
    "executor": (_CONFIG, Call("map", ("evaluate", "jobs")), Call("close")),
    "procedure": (
        _CONFIG,
        Call("run", (), ("out", "seed", "plugins", "executor", "progress", "resume"), asked_for=True),
    ),
}
"""Calls of components of each kind."""

OPTIONAL_CALLS: Mapping[str, tuple[Call, ...]] = {
    "effect": (
        Call("source", (), ("geometry", "context", "frames")),
        Call("source_at", ("x_px", "y_px"), ("geometry",)),
        Call("moved_inverse_depth", ("near", "columns", "rows"), ("geometry",)),
        Call("dark_scale", ("context",)),
        Call("on_view", ("light", "depth_m", "object_id"), ("geometry", "context")),
        Call("lacks", ("rig",)),
        Call("origins", ("camera",)),
        Call("moments", ("mean_dn", "variance_dn2"), ("geometry", "context")),
        Call("guesses_from", ("captures",)),
        Call("estimate_from", ("captures",)),
    ),
    "rig": (Call("coordinates", ("variables",)),),
    "scene": (Call("not_shown", ("rig",), ("exposure", "sensors", "illumination_lux")),),
    "sensor": (Call("lacks", ("rig",)), Call("behind", ("cameras",))),
    "task": (Call("lacks", ("rig",)), Call("untrained")),
    "optimizer": (Call("recommend", ("count",)), Call("choose", ("finalists",))),
    "procedure": (Call("check", (), ("seed", "plugins"), asked_for=True),),
}
"""Calls of optional members of components."""
