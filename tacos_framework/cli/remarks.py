"""Remarks of ``tacos-run --check`` on a study without faults."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator

from tacos_framework.contracts import SceneBase, optional
from tacos_framework.plan import Plan
from tacos_framework.plan.notes import (
    DoubtedParts,
    doubted_parts,
    notes_on_catalogs,
    notes_on_constraints,
    notes_on_middle,
    notes_on_search,
    notes_on_worlds,
)
from tacos_framework.plan.origins import notes_on_assumptions
from tacos_framework.plan.units import doubts_of_units

SHOWN = 5
"""Doubts that are listed unless all are asked for."""

WIDTH = 100
"""Characters of a listed doubt unless all are asked for."""

PARTS_NAMED = 3
"""Parts that share a doubt and are named before the others are counted, unless all are asked for."""


def remarks(plan: Plan, *, verbose: bool) -> Iterator[str]:
    """Remarks for whoever builds a camera of this study, line by line.

    `verbose`: all doubts about parts in full, in place of a short list.
    """
    for note in (
        *notes_on_search(plan),
        *notes_on_catalogs(plan),
        *notes_on_constraints(plan),
        *notes_on_assumptions(plan),
        *doubts_of_units(plan),
        *notes_on_middle(plan),
        *notes_on_worlds(plan),
        *notes_on_shown(plan),
    ):
        yield f"note: {note}"
    for doubted in doubted_parts(plan):
        yield from _all_of(doubted) if verbose else _first_of(doubted)


def notes_on_shown(plan: Plan) -> Iterator[str]:
    """Notes on recordings; nothing is loaded where no scene can be asked."""
    scenes = [plan.nodes[name] for name in plan.graph.of_kind("scene")]
    if any(callable(optional(scene.cls, SceneBase, "not_shown")) for scene in scenes):
        from tacos_framework import simulation

        yield from simulation.notes_on_shown(plan)


def _all_of(doubted: DoubtedParts) -> Iterator[str]:
    yield f"{_title(doubted)}:"
    yield from (f"  {', '.join(names)}: {doubt}" for doubt, names in doubted.by_doubt.items())


def _first_of(doubted: DoubtedParts) -> Iterator[str]:
    yield f"{_title(doubted)} (--verbose: all, in full):"
    for doubt, names in list(doubted.by_doubt.items())[:SHOWN]:
        named = ", ".join(names[:PARTS_NAMED])
        more = f" and {len(names) - PARTS_NAMED} more" if len(names) > PARTS_NAMED else ""
        yield "  " + textwrap.shorten(f"{named}{more}: {doubt}", WIDTH, placeholder=" ...")
    if (left := len(doubted.by_doubt) - SHOWN) > 0:
        yield f"  and {left} more {'doubt' if left == 1 else 'doubts'}"


def _title(doubted: DoubtedParts) -> str:
    return f"note: Doubts about {doubted.doubted} of {doubted.parts} parts of {doubted.catalog}"
