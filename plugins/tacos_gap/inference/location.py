"""Location of the gap: statistics that are significant, at a controlled rate of false discoveries."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_gap.inference.problem import Problem
from tacos_gap.inference.significance import block_test, discoveries
from tacos_gap.inference.unknown import SLACK, block_index, block_names

FALSE_DISCOVERIES = 0.05

LEAST_SQUARE = 1.5
"""Mean square of a statistic below which it is no place: models are never exact [noise floor^2]."""


@dataclass(frozen=True)
class Place:
    stage: str
    statistic: str
    z: float  # largest difference, signed [noise floor]
    share: float  # its share in the squared gap
    at: dict[str, Any]
    captures: tuple[str, ...]


def locate(problem: Problem, z: NDArray[np.float64]) -> list[Place]:
    """Statistics that differ by more than the noise floor, largest share first.

    Blocks (a statistic of a capture) are tested against the simulator's own replicates (see `block_test`),
    and chosen by Benjamini and Hochberg 1995 (J. R. Statist. Soc. B 57(1)).
    """
    if not len(z):
        return []
    blocks, names = block_index(problem), block_names(problem)
    own = np.bincount(blocks, z**2, len(names))
    sizes = np.bincount(blocks, minlength=len(names))
    p_values = block_test(z, problem.null_replicates, blocks, SLACK).p_values
    found = discoveries(p_values, FALSE_DISCOVERIES)
    total = float(np.sum(own))
    places: dict[tuple[str, str], Place] = {}
    for k in np.flatnonzero(found & (own > LEAST_SQUARE * sizes)):
        members = np.flatnonzero(blocks == k)
        peak = int(members[np.argmax(np.abs(z[members]))])
        label = problem.labels[peak]
        key = (label.stage, label.statistic)
        share = float(own[k] / total)
        if key not in places:
            places[key] = Place(*key, float(z[peak]), share, dict(label.at), (label.capture,))
            continue
        before = places[key]
        larger = abs(z[peak]) > abs(before.z)
        places[key] = Place(
            *key,
            float(z[peak]) if larger else before.z,
            before.share + share,
            dict(label.at) if larger else before.at,
            (*before.captures, label.capture),
        )
    return sorted(places.values(), key=lambda place: -place.share)
