"""Where the gap lies: statistics that are significant, at a controlled rate of false discoveries."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from tacos_gap.problem import Problem, robust
from tacos_gap.unknown import block_index, block_names

FALSE_DISCOVERIES = 0.05


@dataclass(frozen=True)
class Place:
    """A statistic that differs.

    Parameters
    ----------
    stage, statistic
        What it is.
    z
        Largest difference, signed [noise floor].
    share
        Its share in the squared gap.
    at
        Where the largest difference was.
    captures
        Where it shows.
    """

    stage: str
    statistic: str
    z: float
    share: float
    at: dict[str, Any]
    captures: tuple[str, ...]


def locate(problem: Problem, z: NDArray[np.float64]) -> list[Place]:
    """Statistics that differ by more than the noise floor, largest share first.

    Blocks (a statistic of a capture) are tested against a scaled chi-squared that matches the mean and
    variance of the null replicates, and chosen by Benjamini and Hochberg 1995 (J. R. Statist. Soc. B
    57(1)).
    """
    if not len(z):
        return []
    blocks, names = block_index(problem), block_names(problem)
    own = np.bincount(blocks, robust(z) ** 2, len(names))
    sizes = np.bincount(blocks, minlength=len(names))
    floor = np.stack([np.bincount(blocks, robust(f) ** 2, len(names)) for f in problem.null_replicates])
    scale = np.maximum(floor.var(axis=0), 1e-6) / (2 * np.maximum(floor.mean(axis=0), 1e-6))
    freedom = np.maximum(floor.mean(axis=0) / scale, 0.5)
    allowed = 0.5 * sizes  # models are never exact
    p_values = chi2.sf(np.maximum(own - allowed, 0) / scale, freedom)
    found = _discoveries(p_values, FALSE_DISCOVERIES)
    total = float(np.sum(own))
    places: dict[tuple[str, str], Place] = {}
    for k in np.flatnonzero(found & (own > 1.5 * sizes)):
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


def _discoveries(p_values: NDArray[np.float64], rate: float) -> NDArray[np.bool_]:
    """Which p-values are discoveries at a false discovery rate."""
    order = np.argsort(p_values)
    limits = rate * np.arange(1, len(p_values) + 1) / len(p_values)
    below = np.flatnonzero(p_values[order] <= limits)
    found = np.zeros(len(p_values), bool)
    if len(below):
        found[order[: below[-1] + 1]] = True
    return found
