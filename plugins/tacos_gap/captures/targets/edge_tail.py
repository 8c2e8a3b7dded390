"""A straight edge that is sharp in its core and has a broad tail, as no blur of one part makes it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.capture import RealCapture
from tacos_gap.captures.targets.slanted_edge import PLATEAU_PX, SlantedEdge, edge_spread, find_edge

LEAST_SHARE = 0.02
"""Share of an edge's contrast in its tail from which on it is named: discs, streaks and Gaussians leave less
than a hundredth there, so far out."""

_BEYOND_CORES = 4.0
"""Standard deviations of a Gaussian as wide as the core from which on its tail is looked at: 1 in 15,000."""

_WINDOW_PX = 2.0
_SURE = 5.0
"""Standard errors that the share must be."""

_BETWEEN_QUARTERS = 1.349
"""Width between a quarter and three quarters of a Gaussian's rise, over its standard deviation."""


@dataclass(frozen=True)
class EdgeTail:
    """Rise of an edge: most of it within its core, a share outside of it."""

    core_px: float
    """Standard deviation of a Gaussian that rises from a quarter to three quarters over the same width
    [px]."""
    share: float  # share of the contrast that lies farther out than the core reaches, on both sides together


def edge_tail(plane: NDArray[np.floating], edge: SlantedEdge) -> EdgeTail | None:
    """The tail of an edge; None where it has none that noise could not make, or is too blurred to say."""
    places, levels = edge_spread(plane, edge)
    core = (_reached(places, levels, 0.75) - _reached(places, levels, 0.25)) / _BETWEEN_QUARTERS
    begins = max(_BEYOND_CORES * core, 1.0)
    if begins + _WINDOW_PX > PLATEAU_PX - 1:
        return None
    far, errors = [], []
    for distance, missing in ((-places, levels), (places, 1 - levels)):
        inside = (distance >= begins) & (distance < begins + _WINDOW_PX)
        side = missing[distance > PLATEAU_PX]
        far.append(float(missing[inside].mean()))
        errors.append(float(side.std()) / np.sqrt(inside.sum()))
    share = sum(far)
    if min(far) < LEAST_SHARE / 5 or share < max(LEAST_SHARE, _SURE * float(np.hypot(*errors))):
        return None
    return EdgeTail(core, share)


def _reached(places: NDArray[np.float64], levels: NDArray[np.float64], level: float) -> float:
    """Place at which an edge first rises over a level [px]."""
    k = max(int(np.argmax(levels > level)), 1)
    return float(np.interp(level, levels[k - 1 : k + 1], places[k - 1 : k + 1]))


def tails_of(captures: Sequence[RealCapture]) -> list[str]:
    """Sentence on edges with a broad tail, by the one that has most, and what to photograph next."""
    found = []
    for capture in captures:
        if capture.kind != "edge":
            continue
        mean = capture.real_dn.mean(axis=0)
        plane = mean[..., mean.shape[-1] // 2]
        if (edge := find_edge(plane)) is not None and (tail := edge_tail(plane, edge)) is not None:
            found.append((tail.share, tail.core_px, capture.id))
    if not found:
        return []
    share, core, name = max(found)
    return [
        f"The edge spread has a broad tail: in {name} the edge rises within a blur of {core:.1f} px, but "
        f"{share:.0%} of its contrast lies in a veil around it. That is stray light in the lens, a hazy or "
        "dirty lens, or a print that bleeds. Take the edge again with a clean lens and no lamp nearby, "
        "and once of a razor blade before an even light: a tail that stays is the lens's own."
    ]
