"""Each part at its own best optics: the highest posterior mean among cameras that keep all constraints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_decision.model import CameraModel, Point
from tacos_decision.pool import Parts, Pool, part_names
from tacos_framework import Values

Array = NDArray[np.float64]

POOL = 4096
"""Cameras looked at in all. Each costs half a millisecond, most of it for the rig's quantities."""

FEWEST_OPTICS, MOST_OPTICS = 4, 1024
"""Optics looked at for each combination of parts, however many or few there are."""

REFINEMENTS = (0.08, 0.03, 0.01)
"""How far around the best so far is looked, as shares of each variable's range, round after round."""

NEIGHBOURS = 12
"""Cameras looked at in each such round."""


@dataclass(frozen=True)
class BestOfParts:
    cameras: Mapping[tuple[str, ...], Values]
    """Values by the names of the parts; without combinations of which no camera keeps all constraints."""
    means: Mapping[tuple[str, ...], float]
    impossible: Mapping[tuple[str, ...], Mapping[str, float]]
    """By how much the nearest camera of the other combinations breaks each constraint."""
    pool: Sequence[Point]
    """Every feasible camera that was looked at, the cameras the study scored among them."""

    @property
    def best(self) -> Values:
        """The camera of highest posterior mean."""
        return self.cameras[max(self.means, key=lambda names: self.means[names])]


def best_of_parts(model: CameraModel, pool: Pool) -> BestOfParts:
    """Look for the best optics of every combination of parts."""
    combinations = {tuple(part.name for part in parts): parts for parts in pool.parts}
    places = pool.spread(min(MOST_OPTICS, max(FEWEST_OPTICS, POOL // len(combinations))))
    looked_at, impossible = _feasible(model, pool, combinations, places)
    for camera in model.scored.values():
        names = part_names(pool.catalogs, camera)
        if names in looked_at:
            looked_at[names].append(model.point(camera))
    best, means = _best(model, looked_at)
    rng = np.random.default_rng(0)
    most = POOL // (2 * NEIGHBOURS * len(REFINEMENTS))  # as many as there is room for
    finest = sorted(means, key=lambda names: -means[names])[:most]
    for reach in REFINEMENTS if pool.dimensions else ():
        near: dict[tuple[str, ...], list[Point]] = {}
        for names in finest:
            steps = pool.place(best[names].camera) + reach * rng.standard_normal(
                (NEIGHBOURS, pool.dimensions)
            )
            found = [pool.camera(combinations[names], np.clip(step, 0, 1)) for step in steps]
            near[names] = [best[names], *model.feasible(found)]
            looked_at[names] += near[names][1:]
        better, higher = _best(model, near)
        best, means = {**best, **better}, {**means, **higher}
    everything = [point for found in looked_at.values() for point in found]
    return BestOfParts({names: point.camera for names, point in best.items()}, means, impossible, everything)


def _feasible(
    model: CameraModel, pool: Pool, combinations: Mapping[tuple[str, ...], Parts], places: Array
) -> tuple[dict[tuple[str, ...], list[Point]], dict[tuple[str, ...], Mapping[str, float]]]:
    """For each combination its cameras that keep all constraints, or else what the nearest one breaks."""
    feasible: dict[tuple[str, ...], list[Point]] = {}
    impossible: dict[tuple[str, ...], Mapping[str, float]] = {}
    for names, parts in combinations.items():
        nearest: Mapping[str, float] | None = None
        for place in places:
            camera = pool.camera(parts, place)
            broken = model.record.broken(camera)
            if not broken:
                feasible.setdefault(names, []).append(model.point(camera))
            elif nearest is None or sum(broken.values()) < sum(nearest.values()):
                nearest = broken
        if names not in feasible:
            impossible[names] = nearest or {}
    return feasible, impossible


def _best(
    model: CameraModel, candidates: Mapping[tuple[str, ...], Sequence[Point]]
) -> tuple[dict[tuple[str, ...], Point], dict[tuple[str, ...], float]]:
    """The candidate of highest posterior mean of each combination, and that mean."""
    flat = [(names, point) for names, points in candidates.items() for point in points]
    if not flat:
        return {}, {}
    mean = model.posterior_of([point for _, point in flat]).mean
    best: dict[tuple[str, ...], Point] = {}
    means: dict[tuple[str, ...], float] = {}
    for (names, point), value in zip(flat, mean.tolist(), strict=True):
        if value > means.get(names, -np.inf):
            best[names], means[names] = point, value
    return best, means
