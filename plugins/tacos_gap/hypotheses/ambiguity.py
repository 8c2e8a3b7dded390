"""Effects that captures cannot tell apart, as effects declare it, and the capture that would."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tacos_framework import EffectBase, LookAlike, calling, optional
from tacos_gap.captures import RealCapture


@dataclass(frozen=True)
class NextCapture:
    """A capture to take: its kind, and what it would tell."""

    kind: str
    why: str


def confused_with(
    effect: str, effects: Mapping[str, type[Any]], captures: Sequence[RealCapture]
) -> dict[str, NextCapture]:
    """Effects these captures cannot tell from `effect`, each with the capture that would."""
    found: dict[str, NextCapture] = {}
    for name, other, alike in _declared(effects):
        if effect in (name, other):
            with calling(f"effect.{name}", doing="look_alikes"):
                holds = alike.holds(captures)
            if holds:
                found.setdefault(other if effect == name else name, NextCapture(alike.capture, alike.why))
    return found


def _declared(effects: Mapping[str, type[Any]]) -> Iterator[tuple[str, str, LookAlike]]:
    for name, cls in effects.items():
        for alike in optional(cls, EffectBase, "look_alikes"):
            yield name, alike.effect, alike
