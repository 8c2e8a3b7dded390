"""Cameras that may be called equal to the best, and the range of each variable that keeps them so."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tacos_decision.model import CameraModel
from tacos_decision.optimum import BestOfParts
from tacos_decision.pool import Pool, joined, part_names
from tacos_framework import CatalogChoice, Categorical, Fitness, Values

TOLD_APART = 0.05
"""A camera is no equal once the probability that it lies within the margin of the best falls below this."""

MOST_DRAWN = 1000
"""Cameras that joint draws are made for, those of highest posterior mean; they take half a second."""

DRAWS_OF_MANY = 1000
"""Joint draws for these; a probability of 5 % is then good to 1 %."""

STEPS = 64
"""Values a variable's range is divided into to find its tolerance."""

RULE = (
    "Equal: with a probability of 5 % or more within the margin of the best camera, by the model of all that "
    "the study scored. Tolerance: the mean loss stays within the margin, all other variables as designed."
)


def equivalence(model: CameraModel, pool: Pool, found: BestOfParts, fitness: Fitness) -> dict[str, Any]:
    """The key ``equivalent``.

    - `model`: what is known of the fitness.
    - `pool`: the cameras of the design space.
    - `found`: cameras that keep all constraints, and the best of them.
    - `fitness`: its margin is the difference that does not matter.
    """
    mean = model.posterior_of(found.pool).mean
    best = int(np.argmax(mean))
    margin = fitness.margin
    order = _hopeful(found, pool, mean)
    likely = model.draws_of([found.pool[i] for i in order], DRAWS_OF_MANY)
    reference = likely[:, order.index(best)][:, None]
    within = (likely >= reference - margin).mean(axis=0)
    first = np.bincount(likely.argmax(axis=1), minlength=len(order)) / len(likely)
    equals = [found.pool[i].camera for i, p in zip(order, within, strict=True) if p >= TOLD_APART]
    probability: dict[str, float] = {}
    for i, p in zip(order, within.tolist(), strict=True):
        name = joined(part_names(pool.catalogs, found.pool[i].camera))
        if p >= TOLD_APART and name:
            probability[name] = max(p, probability.get(name, 0.0))
    parts = sorted(probability, key=lambda name: -probability[name])
    return {
        "margin": margin,
        "margins": fitness.margins,
        "rule": RULE,
        "parts": parts,
        "probability": {name: probability[name] for name in parts},
        "optimal": [
            _optimal(model, found.pool[order[j]].camera, first[j]) for j in np.argsort(-first) if first[j]
        ],
        "range": _ranges(pool, equals),
        "derived_range": _derived_ranges(model, equals),
        "tolerance": _tolerances(model, pool, margin),
    }


def _optimal(model: CameraModel, camera: Values, probability: float) -> dict[str, Any]:
    """A camera, parts by their names, and the share of draws in which it is the best of all."""
    derived = {name: value for name, value in model.record.derived(camera).items() if math.isfinite(value)}
    named = {name: value["name"] if isinstance(value, Mapping) else value for name, value in camera.items()}
    return {"camera": named, "derived": derived, "probability": float(probability)}


def _hopeful(found: BestOfParts, pool: Pool, mean: np.ndarray) -> list[int]:
    """The cameras that draws are made for: the most promising, the best of each parts among them."""
    ranked = [int(i) for i in np.argsort(-mean, kind="stable")]
    first = {part_names(pool.catalogs, found.pool[i].camera): i for i in reversed(ranked)}
    return list(dict.fromkeys([*sorted(first.values(), key=lambda i: -mean[i]), *ranked]))[:MOST_DRAWN]


def _ranges(pool: Pool, cameras: Sequence[Values]) -> dict[str, list[Any]]:
    """Of each variable but parts the values that the cameras have: two ends, or a list of choices."""
    ranges: dict[str, list[Any]] = {}
    for variable in pool.space.variables:
        values: list[Any] = [camera[variable.name] for camera in cameras]
        if isinstance(variable, Categorical):
            ranges[variable.name] = [value for value in variable.values if value in values]
        elif not isinstance(variable, CatalogChoice):
            ranges[variable.name] = [min(values), max(values)]
    return ranges


def _derived_ranges(model: CameraModel, cameras: Sequence[Values]) -> dict[str, list[float]]:
    """Of each derived quantity the two ends that the cameras have; parts differ, fields of view agree."""
    derived = [model.record.derived(camera) for camera in cameras]
    known = {
        name: [float(each[name]) for each in derived if math.isfinite(each.get(name, math.nan))]
        for name in dict.fromkeys(name for each in derived for name in each)
    }
    return {name: [min(values), max(values)] for name, values in known.items() if values}


def _tolerances(model: CameraModel, pool: Pool, margin: float) -> dict[str, list[Any]]:
    """Around the designed camera, one variable at a time."""
    designed = model.record.cameras[0].camera
    if designed is None or model.record.broken(designed):
        return {}
    tolerances: dict[str, list[Any]] = {}
    for variable in pool.space.variables:
        if isinstance(variable, CatalogChoice):
            continue
        if isinstance(variable, Categorical):
            values: list[Any] = list(variable.values)
        else:
            gene = variable.genes[0]
            scale = np.linspace(gene.lower, gene.upper, STEPS + 1)
            values = sorted(
                {variable.decode([float(value)])[0] for value in scale} | {designed[variable.name]}
            )
        cameras = [{**designed, variable.name: value} for value in values]
        feasible = [not model.record.broken(camera) for camera in cameras]
        kept = [camera for camera, ok in zip(cameras, feasible, strict=True) if ok]
        mean = iter(model.posterior([designed, *kept]).mean.tolist())
        least = next(mean) - margin
        good = [ok and next(mean) >= least for ok in feasible]
        if isinstance(variable, Categorical):
            tolerances[variable.name] = [value for value, fine in zip(values, good, strict=True) if fine]
        else:
            tolerances[variable.name] = _around(values, good, values.index(designed[variable.name]))
    return tolerances


def _around(values: Sequence[Any], good: Sequence[bool], at: int) -> list[Any]:
    """The ends of the run of good values around a place, which is good itself."""
    first = last = at
    while first > 0 and good[first - 1]:
        first -= 1
    while last + 1 < len(values) and good[last + 1]:
        last += 1
    return [values[first], values[last]]
