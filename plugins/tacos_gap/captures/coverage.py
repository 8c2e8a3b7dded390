"""Limits of a folder of captures, whatever they show, and what to photograph in addition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from tacos_framework import EffectBase, ShownBy, calling, optional
from tacos_gap.captures.capture import RealCapture
from tacos_plugins.effects.shown_by import DARKS_OF_TWO_TIMES, LEVELS


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


def beyond_one_time(captures: Sequence[RealCapture], effects: Mapping[str, type[Any]]) -> set[str]:
    """Effects that grow with the exposure time, where none is stated, or lit captures have one and no dark.

    What they add is then an offset, and a rate would be a number out of a time that nobody wrote.
    """
    times = {capture.context.exposure_s for capture in captures if capture.exposure_stated}
    if len(times) > 1 or (times and any(capture.kind == "dark" for capture in captures)):
        return set()
    return _that_need(DARKS_OF_TWO_TIMES, effects)


def beyond_own_levels(captures: Sequence[RealCapture], effects: Mapping[str, type[Any]]) -> set[str]:
    """Effects on how bright all is, where each expectation has the light that its own pictures show."""
    lit = [capture for capture in captures if capture.kind not in ("dark", "board")]
    if not lit or not all(capture.own_level or capture.own_edges for capture in lit):
        return set()
    return _that_need(LEVELS, effects)


def _that_need(captures: ShownBy, effects: Mapping[str, type[Any]]) -> set[str]:
    return {name for name, cls in effects.items() if captures in optional(cls, EffectBase, "shown_by")}
