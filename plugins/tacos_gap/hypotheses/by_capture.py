"""Settings that a camera sets anew for each capture, as its focus: a hypothesis has one value for each.

Such a value is called ``setting@capture``. Captures without one of their own have the median of the others.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from statistics import median, median_low
from typing import Any

from tacos_framework import EffectBase, ShownBy, optional
from tacos_gap.captures import RealCapture

_AT = "@"

FEWEST_CAPTURES = 2
"""Captures that must show an effect by themselves before each may have a value of its own."""

PENALTY_OF_A_VALUE = 2.0
"""What each value beyond the first must gain in log score: no other capture holds it to account [nat]."""


def setting_of(name: str) -> str:
    """The setting that a parameter is a value of.

    >>> setting_of("radius_px@view_1"), setting_of("radius_px")
    ('radius_px', 'radius_px')
    """
    return name.partition(_AT)[0]


def of_capture(setting: str, capture: str) -> str:
    return f"{setting}{_AT}{capture}"


def is_of_one_capture(name: str) -> bool:
    return _AT in name


def own_values(values: Mapping[str, Any], setting: str) -> dict[str, Any]:
    """Values of a setting by capture; empty where one value holds for all.

    >>> own_values({"radius_px@near": 1.0, "radius_px@far": 4.0}, "radius_px")
    {'near': 1.0, 'far': 4.0}
    """
    parts = ((name.partition(_AT), value) for name, value in values.items() if is_of_one_capture(name))
    return {capture: value for (name, _, capture), value in parts if name == setting}


def values_in(values: Mapping[str, Any], capture: str | None = None) -> dict[str, Any]:
    """Settings as they hold in one capture, or in any other.

    >>> values = {"growth": 0.0, "radius_px@a": 1.0, "radius_px@b": 4.0, "radius_px@c": 2.0}
    >>> values_in(values, "b"), values_in(values)
    ({'growth': 0.0, 'radius_px': 4.0}, {'growth': 0.0, 'radius_px': 2.0})
    """
    settings = {name: value for name, value in values.items() if not is_of_one_capture(name)}
    for setting in dict.fromkeys(setting_of(name) for name in values if is_of_one_capture(name)):
        own = own_values(values, setting)
        settings[setting] = own[capture] if capture in own else _middle(list(own.values()))
    return settings


def _middle(values: Sequence[Any]) -> Any:
    """The median; of whole numbers one of them."""
    return median_low(values) if all(type(value) is int for value in values) else median(values)


def captures_with_values(values: Mapping[str, Any]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name.partition(_AT)[2] for name in values if is_of_one_capture(name)))


def penalty(names: Sequence[str]) -> float:
    """Gain that parameters need beyond one value of each setting [nat].

    >>> penalty(["radius_px@a", "radius_px@b", "radius_px@c", "growth"])
    4.0
    """
    own = [setting_of(name) for name in names if is_of_one_capture(name)]
    return PENALTY_OF_A_VALUE * (len(own) - len(set(own)))


def guesses_by_capture(cls: type[Any], captures: Sequence[RealCapture]) -> Iterator[dict[str, Any]]:
    """Initial guesses of an effect with a value for each capture that shows it.

    They are what the class guesses from each capture by itself: neutral where that is nothing. A class that
    cannot guess begins with the same value everywhere. A codec leaves its traces in files of any kind.
    """
    settings: Sequence[str] = optional(cls, EffectBase, "by_capture")
    needs: Sequence[ShownBy] = optional(cls, EffectBase, "shown_by")
    shown = [c for c in captures if cls.stage == "codec" or c.is_structured]
    seen = [c for c in shown if all(need.met([c]) for need in needs)]
    if not settings or len(seen) < FEWEST_CAPTURES:
        return
    if not callable(guess := optional(cls, EffectBase, "guesses_from")):
        for own in optional(cls, EffectBase, "initial_guesses") or ():
            yield _spread(settings, own, {c.id: own for c in seen}, cls.neutral)
        return
    alone: dict[str, Mapping[str, Any]] = {c.id: next(iter(guess([c])), {}) for c in seen}
    if first := next((found for found in alone.values() if found), None):
        yield _spread(settings, first, alone, cls.neutral)


def _spread(
    settings: Sequence[str],
    common: Mapping[str, Any],
    alone: Mapping[str, Mapping[str, Any]],
    neutral: Mapping[str, Any],
) -> dict[str, Any]:
    """A guess whose `settings` have a value for each capture; all others are those of `common`."""
    values = {name: value for name, value in common.items() if name not in settings}
    for name in settings:
        values |= {of_capture(name, capture): own.get(name, neutral[name]) for capture, own in alone.items()}
    return values
