"""Checks of a class against its kind: every call of the framework has to work."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, get_args

from tacos_framework.components import Component
from tacos_framework.contracts import (
    BASES,
    PROTOCOLS,
    STAGES,
    VERBS,
    WANTED_FILES,
    ScoreScale,
    Trainable,
    learns,
)
from tacos_framework.errors import did_you_mean
from tacos_framework.plugins.contract_calls import CALLS, OPTIONAL_CALLS, scorer_faults
from tacos_framework.settings import Settings

ALIKE = 0.8
"""Share of letters in common (difflib's ratio) from which a name counts as misspelt: two letters of ten may
be wrong. No component that ships has a member so near to another."""


def contract_faults(component: Component, cls: type[Any]) -> list[str]:
    """Faults of a class as a component of its kind, in sentences; empty if it fits."""
    if not isinstance(cls, type):
        return [f"{component.target} is a {type(cls).__name__}, not a class"]
    faults = [*_missing(component.kind, cls), *_misspelt(component.kind, cls), *_misfits(component.kind, cls)]
    return faults or [*_called_wrongly(component.kind, cls)]


def _missing(kind: str, cls: type[Any]) -> Iterator[str]:
    """Members that are not there at all."""
    for verb in VERBS[kind]:
        if not callable(getattr(cls, verb, None)):
            yield f"{cls.__name__} has no method {verb}"
    if kind == "effect" and not any(callable(getattr(cls, name, None)) for name in ("on_array", "source")):
        yield (
            f"{cls.__name__} has no method on_array, which changes the samples of one camera, "
            "nor source in its place, for an effect that only moves pixels"
        )
    if not _is_settings(getattr(cls, "Config", None)):
        yield f"{cls.__name__}.Config is not a tacos_framework.settings.Settings class"
    for name in sorted(_class_attributes(kind)):
        if not hasattr(cls, name):
            yield f"{cls.__name__} has no class attribute {name}"
    for name in sorted(_attributes(kind)):
        if not hasattr(cls, name) and not any(
            name in vars(each).get("__annotations__", {}) for each in cls.__mro__
        ):
            yield f"{cls.__name__} has no attribute {name}: give it one, or a property, or its annotation"


def _misspelt(kind: str, cls: type[Any]) -> Iterator[str]:
    """Members that the framework does not read, and that are nearly called as one it would."""
    known = known_members(kind)
    own = own_members(cls)
    unused = sorted(known - own)
    for name in sorted(own - known):
        if meant := difflib.get_close_matches(name, unused, n=1, cutoff=ALIKE):
            yield f"{cls.__name__}.{name} is no member of the contract. Did you mean {meant[0]!r}?"


def unread_members(component: Component, cls: type[Any]) -> list[str]:
    """Public members of a class that the contract of its kind does not have: helpers, or mistakes."""
    return sorted(own_members(cls) - known_members(component.kind))


def known_members(kind: str) -> set[str]:
    """All members that the framework may read of a component of a kind."""
    protocols = [PROTOCOLS[kind], *([Trainable] if kind == "task" else [])]
    found = {name for each in protocols for name in (*vars(each), *each.__annotations__)}
    found |= {call.verb for call in (*CALLS[kind], *OPTIONAL_CALLS.get(kind, ()))}
    for base in BASES[kind].__mro__ if kind in BASES else ():
        found |= {*vars(base), *vars(base).get("__annotations__", {})}
    return {name for name in found if not name.startswith("_")}


def own_members(cls: type[Any]) -> set[str]:
    """Public members that a class has of itself or of classes other than those of the framework."""
    theirs = [
        each
        for each in cls.__mro__
        if each.__module__.partition(".")[0] not in ("builtins", "tacos_framework")
    ]
    return {
        name
        for each in theirs
        for name in (*vars(each), *vars(each).get("__annotations__", {}))
        if not name.startswith("_")
    }


def _class_attributes(kind: str) -> set[str]:
    """Attributes and properties the Protocol of a kind asks the class itself for."""
    protocol = PROTOCOLS[kind]
    properties = {name for name, member in vars(protocol).items() if isinstance(member, property)}
    of_class = {name for name, hint in protocol.__annotations__.items() if str(hint).startswith("ClassVar")}
    return (of_class | properties) - {"Config"}


def _attributes(kind: str) -> set[str]:
    """Attributes the Protocol of a kind asks an instance for."""
    hints = PROTOCOLS[kind].__annotations__
    return {name for name, hint in hints.items() if not str(hint).startswith("ClassVar")}


def _misfits(kind: str, cls: type[Any]) -> Iterator[str]:
    """Class attributes that are there and not what they should be."""
    name = cls.__name__
    if kind == "effect":
        yield from _effect_misfits(cls)
    if kind == "rig":
        if hasattr(cls, "Variables") and not _is_settings(cls.Variables):
            yield f"{name}.Variables is not a tacos_framework.settings.Settings class"
        if not _maps_text(getattr(cls, "derived_quantities", {})):
            yield f"{name}.derived_quantities is no mapping of names to units, such as {{'hfov_deg': 'deg'}}"
    if kind == "task":
        yield from _score_misfits(cls)
        wanted = getattr(cls, "wants", None)
        if isinstance(wanted, str) and wanted not in WANTED_FILES:
            meant = did_you_mean(wanted, WANTED_FILES)
            yield f"{name}.wants is {wanted!r}, not one of {', '.join(WANTED_FILES)}. {meant}".rstrip(". ")
        if getattr(cls, "Training", None) is not None and not _is_settings(cls.Training):
            yield f"{name}.Training is not a tacos_framework.settings.Settings class"


def _effect_misfits(cls: type[Any]) -> Iterator[str]:
    name = cls.__name__
    if hasattr(cls, "stage") and cls.stage not in STAGES:
        meant = did_you_mean(cls.stage, STAGES) if isinstance(cls.stage, str) else ""
        yield f"{name}.stage is {cls.stage!r}, not one of {', '.join(STAGES)}. {meant}".rstrip(". ")
    neutral = getattr(cls, "neutral", {})
    if not isinstance(neutral, Mapping):
        yield f"{name}.neutral is {neutral!r}, not a mapping of settings to the values that switch it off"
    elif _is_settings(getattr(cls, "Config", None)):
        known = [*cls.Config.model_fields]
        for key in neutral:
            if key not in known:
                meant = did_you_mean(str(key), known)
                yield f"{name}.neutral has {key!r}, which is no setting. {meant}".rstrip()
    if not isinstance(getattr(cls, "rank", 0), int):
        yield f"{name}.rank is {cls.rank!r}, not a whole number"


def _score_misfits(cls: type[Any]) -> Iterator[str]:
    name, scores = cls.__name__, getattr(cls, "scores", ("",))
    if not _are_texts(scores, tuple) or not scores:
        yield f"{name}.scores is {scores!r}, not a tuple of names such as ('inliers',)"
        return
    lower = getattr(cls, "lower_is_better", ())
    if not _are_texts(lower, tuple, list, set, frozenset):
        yield f"{name}.lower_is_better is {lower!r}, not a set of names such as {{'error_px'}}"
        lower = ()
    for score in lower:
        if score not in scores:
            meant = did_you_mean(str(score), scores)
            yield f"{name}.lower_is_better has {score!r}, which is no score of it. {meant}"
    for attribute in ("score_scales", "depends_on", "margins"):
        given = getattr(cls, attribute, {})
        if not isinstance(given, Mapping) or not set(given) <= set(scores):
            yield f"{name}.{attribute} is {given!r}, not a mapping with scores of it as keys"
            continue
        for score, value in given.items():
            if attribute == "score_scales" and value not in get_args(ScoreScale):
                known = ", ".join(get_args(ScoreScale))
                yield f"{name}.score_scales has {value!r} for {score!r}, not one of {known}"
            if attribute == "margins" and not (isinstance(value, int | float) and value >= 0):
                yield f"{name}.margins has {value!r} for {score!r}, not a number of 0 or more"
            if attribute == "depends_on" and not _are_texts(value, tuple, list):
                yield f"{name}.depends_on has {value!r} for {score!r}, not a tuple of names of coordinates"


def _called_wrongly(kind: str, cls: type[Any]) -> Iterator[str]:
    """Methods that cannot be called with what the framework supplies."""
    calls = [call for call in CALLS[kind] if call.verb == "__init__" or hasattr(cls, call.verb)]
    calls += [call for call in OPTIONAL_CALLS.get(kind, ()) if callable(getattr(cls, call.verb, None))]
    if kind == "task" and learns(cls):
        calls += CALLS["trainable"]
    for call in calls:
        yield from call.faults(cls)
    if kind == "task":
        yield from scorer_faults(cls)


def _is_settings(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, Settings)


def _are_texts(given: Any, *kinds: type[Iterable[Any]]) -> bool:
    return isinstance(given, kinds) and all(isinstance(each, str) for each in given)


def _maps_text(given: Any) -> bool:
    return isinstance(given, Mapping) and all(isinstance(each, str) for each in (*given, *given.values()))
