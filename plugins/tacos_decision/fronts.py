"""Several aims at once: the cameras that none beats in all of them, found on the model and scored again.

References
----------
K. Deb et al., "A fast and elitist multiobjective genetic algorithm: NSGA-II", IEEE Trans. Evol. Comput. 6,
2002.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_decision.model import CameraModel, interval
from tacos_decision.pool import Pool, camera_at, joined, part_names
from tacos_framework import Fault, UserError, Values, content_key, quantity

Array = NDArray[np.float64]

POPULATION = 64
"""Cameras of a generation of NSGA-II, and the most points of a front."""

GENERATIONS = 40
"""Generations of NSGA-II; the model answers them in seconds."""

MOST_SCORED = 8
"""Points of the front that are rendered, spread along it; the others are the model's word alone."""


def front(model: CameraModel, pool: Pool) -> tuple[dict[str, Any] | None, CameraModel]:
    """The key ``front``, and the model that has learnt from what was scored for it.

    None and the same model where the recipe has no objectives.

    Raises `UserError` without pymoo, which the extra ``fronts`` installs.
    """
    objectives = model.record.objectives
    if not objectives:
        return None, model
    found = _undominated(model, _searched(model, pool))
    scored = [found[i] for i in _spread(_aims(model, found))]
    study = model.record.recipe.study
    episodes = model.record.score(scored, study.final_episodes or study.episodes)
    again = [episode for of_camera in episodes for episode in of_camera]
    if again:
        model = CameraModel.fit(replace(model.record, episodes=(*model.record.episodes, *again)))
        found = _undominated(model, found)
    rendered = {content_key(episode.camera) for episode in again}
    if not found:
        return {"objectives": [_as_data(each) for each in objectives], "points": []}, model
    values = _values(model, found)
    draws = model.draws(found)
    low, high = interval(draws)
    points: list[dict[str, Any]] = [
        {
            "camera": dict(camera),
            "part": joined(part_names(pool.catalogs, camera)),
            "values": {each.name: float(value) for each, value in zip(objectives, values[i], strict=True)},
            "fitness": float(draws[:, i].mean()),
            "ci": [float(low[i]), float(high[i])],
            "rescored": content_key(camera) in rendered,
        }
        for i, camera in enumerate(found)
    ]
    first = objectives[0].name
    ordered = sorted(points, key=lambda point: -point["values"][first])
    return {"objectives": [_as_data(each) for each in objectives], "points": ordered}, model


def undominated(aims: Array) -> list[int]:
    """The rows of (rows, aims) numbers, each to be small, that no other matches in all and beats in one.

    >>> undominated(np.array([[1.0, 2.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]]))
    [0, 1, 3]
    """
    no_worse = (aims[:, None, :] <= aims[None, :, :]).all(axis=2)
    better = (aims[:, None, :] < aims[None, :, :]).any(axis=2)
    return [int(i) for i in np.flatnonzero(~(no_worse & better).any(axis=0))]


def _searched(model: CameraModel, pool: Pool) -> list[Values]:
    """The last population of NSGA-II on the posterior means."""
    try:
        from pymoo.algorithms.moo.nsga2 import NSGA2
        from pymoo.core.problem import Problem
        from pymoo.optimize import minimize
    except ImportError as error:
        raise UserError(
            Fault(
                "objectives",
                "pymoo is not installed, which looks for the front",
                "the extra fronts",
                "Install it: pip install tacos-framework[fronts]",
            )
        ) from error
    variables = pool.space.variables

    class Aims(Problem):
        """Cameras as a number in 0..1 for each variable."""

        def __init__(self) -> None:
            super().__init__(
                n_var=len(variables), n_obj=len(model.record.objectives), n_ieq_constr=1, xl=0.0, xu=1.0
            )

        def _evaluate(self, x: Array, out: dict[str, Array], *args: Any, **kwargs: Any) -> None:
            cameras = [camera_at(variables, row) for row in x]
            broken = np.array([sum(model.record.broken(camera).values()) for camera in cameras])
            aims = np.zeros((len(cameras), self.n_obj))
            kept = [i for i, amount in enumerate(broken) if amount == 0]
            if kept:
                aims[kept] = _aims(model, [cameras[i] for i in kept])
            unknown = ~np.isfinite(aims).all(axis=1)
            aims[unknown] = 0.0
            out["F"], out["G"] = aims, (broken + unknown)[:, None]

    ended = minimize(Aims(), NSGA2(pop_size=POPULATION), ("n_gen", GENERATIONS), seed=1, verbose=False)
    if ended.X is None:
        return []
    cameras = [camera_at(variables, row) for row in np.atleast_2d(ended.X)]
    return list({content_key(camera): camera for camera in cameras}.values())


def _undominated(model: CameraModel, cameras: Sequence[Values]) -> list[Values]:
    return [cameras[i] for i in undominated(_aims(model, cameras))] if cameras else []


def _aims(model: CameraModel, cameras: Sequence[Values]) -> Array:
    """(cameras, objectives) numbers to make small; NaN where one is unknown."""
    signs = [-1.0 if objective.aim == "max" else 1.0 for objective in model.record.objectives]
    return _values(model, cameras) * np.array(signs)


def _values(model: CameraModel, cameras: Sequence[Values]) -> Array:
    """(cameras, objectives) in the units of the objectives; NaN where one is unknown."""
    if not cameras:
        return np.zeros((0, len(model.record.objectives)))
    scores = model.mean_scores(cameras)
    rows = []
    for i, camera in enumerate(cameras):
        derived = model.record.derived(camera)
        means = {name: float(values[i]) for name, values in scores.items()}
        found = [quantity(objective.name, camera, derived, means) for objective in model.record.objectives]
        rows.append([math.nan if value is None or isinstance(value, str) else value for value in found])
    return np.array(rows)


def _spread(aims: Array) -> list[int]:
    """At most `MOST_SCORED` rows, evenly spread in the order of the first aim, both ends among them."""
    order = np.argsort(aims[:, 0], kind="stable") if len(aims) else np.zeros(0, dtype=np.int64)
    chosen = np.linspace(0, len(order) - 1, min(MOST_SCORED, len(order))).round().astype(int)
    return [int(order[i]) for i in dict.fromkeys(chosen.tolist())]


def _as_data(objective: Any) -> dict[str, str]:
    return {"name": objective.name, "unit": objective.unit, "aim": objective.aim}
