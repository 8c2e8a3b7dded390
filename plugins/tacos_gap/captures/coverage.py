"""Limits of a folder of captures, whatever they show, and what to photograph in addition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from tacos_framework import EffectBase, calling, optional
from tacos_gap.captures.capture import RealCapture


def untold(captures: Sequence[RealCapture], effects: Mapping[str, type[Any]]) -> dict[str, list[str]]:
    """Effects that captures cannot show, or not tell from others, by what would: as the effects declare it.

    Returns: what to photograph -> names of the effects that need it.
    """
    lacking: dict[str, list[str]] = {}
    for name, cls in effects.items():
        for need in optional(cls, EffectBase, "shown_by"):
            with calling(f"effect.{name}", doing="shown_by"):
                met = need.met(captures)
            if not met:
                lacking.setdefault(need.remedy, []).append(name)
    return lacking


def beyond_own_edges(captures: Sequence[RealCapture], effects: Mapping[str, type[Any]]) -> set[str]:
    """Effects that pictures which expect nothing but their own edges to be sharp cannot show.

    Light, tone and place are then read off the picture that is to be judged. Whatever acts on them changes
    the sharpness of an edge a little as well, and would explain what another blur has done.
    """
    lit = [capture for capture in captures if capture.kind != "dark"]
    if not lit or not all(capture.own_edges for capture in lit):
        return set()
    return {name for names in untold(captures, effects).values() for name in names}


def beyond_even_fields(captures: Sequence[RealCapture], effects: Mapping[str, type[Any]]) -> set[str]:
    """Effects that move pictures, where no capture shows anything that could be seen to move.

    Of a field that is not quite even, or of the colours of a mosaic, a camera turned by twenty degrees sees
    other pixels, and would explain an error of level.
    """
    if any(capture.kind == "board" or capture.is_structured for capture in captures):
        return set()
    return {name for name, cls in effects.items() if callable(optional(cls, EffectBase, "source"))}
