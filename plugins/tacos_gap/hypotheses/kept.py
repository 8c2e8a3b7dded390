"""An explanation as plain data, so that a search that was broken off can go on from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from tacos_gap.hypotheses.parameters import HypothesisTerm

KeptTerm = Mapping[str, Any]
"""``effect``, its ``values`` and the steps of those that are ``free``."""


def as_kept(hypothesis: Sequence[HypothesisTerm]) -> list[KeptTerm]:
    return [
        {"effect": term.name, "values": dict(term.values), "free": dict(term.free)} for term in hypothesis
    ]


def kept_terms(kept: Sequence[KeptTerm], effects: Mapping[str, type[Any]]) -> tuple[HypothesisTerm, ...]:
    """The terms of an explanation that was kept, as far as their effects are still looked for."""
    return tuple(
        HypothesisTerm(each["effect"], effects[each["effect"]], each["values"], each["free"])
        for each in kept
        if each["effect"] in effects
    )
