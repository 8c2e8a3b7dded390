"""Importance of each variable: Sobol indices of the posterior mean, and its course, all else at its best.

References
----------
A. Saltelli et al., "Variance based sensitivity analysis of model output. Design and estimator for the total
sensitivity index", Comput. Phys. Commun. 181, 2010: table 2 (b) for the first order, (f), which is Jansen's,
for the total.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri
from scipy.stats import qmc

from tacos_decision.model import LEVEL, CameraModel
from tacos_decision.pool import Pool, camera_at, value_at
from tacos_framework import CatalogChoice, Categorical, Values, Variable, content_key

Array = NDArray[np.float64]

SAMPLES = 512
"""Rows of each of Saltelli's two matrices; a power of two. Indices are then good to some 0.05."""

STEPS = 32
"""Values of a variable its curve is drawn through."""


def importance(model: CameraModel, pool: Pool, best: Values) -> list[dict[str, Any]]:
    """The key ``importance``: the variable of largest total index first.

    Variables are taken as independent and evenly distributed over their ranges, parts each alike. A camera
    that breaks a constraint counts as one of mean fitness: what may not be built tells nothing.
    """
    variables = pool.space.variables
    first, total = sobol_indices(lambda rows: _fitness(model, variables, rows), len(variables))
    rows = [
        {
            "variable": variable.name,
            "unit": variable.as_data()["unit"],
            "first_order": float(first[i]),
            "total": float(total[i]),
            "curve": _curve(model, variable, best),
        }
        for i, variable in enumerate(variables)
    ]
    return sorted(rows, key=lambda row: -row["total"])


def sobol_indices(
    function: Callable[[Array], Array], dimensions: int, samples: int = SAMPLES
) -> tuple[Array, Array]:
    """First-order and total indices of a function of independent variables.

    - `function`: of (rows, dimensions) numbers in 0..1, each evenly distributed; gives (rows,) values.
    - `dimensions`: how many variables it has.
    - `samples`: rows of each of Saltelli's two matrices, a power of two.

    Returns: two arrays (dimensions,): the share of the variance that goes once a variable is known, and the
    share that stays while it alone is not. Zeros where the function is constant.
    """
    sample = qmc.Sobol(2 * dimensions, scramble=True, seed=np.random.default_rng(0)).random(samples)
    a, b = sample[:, :dimensions], sample[:, dimensions:]
    mixed = []
    for i in range(dimensions):
        rows = a.copy()
        rows[:, i] = b[:, i]
        mixed.append(rows)
    values = function(np.concatenate([a, b, *mixed])).reshape(dimensions + 2, samples)
    f_a, f_b, f_mixed = values[0], values[1], values[2:]
    variance = float(np.var(values[:2]))
    if variance <= 1e-18:
        return np.zeros(dimensions), np.zeros(dimensions)
    centre = values[:2].mean()
    first = ((f_b - centre) * (f_mixed - f_a)).mean(axis=1) / variance
    total = 0.5 * ((f_a - f_mixed) ** 2).mean(axis=1) / variance
    return np.clip(first, 0.0, 1.0), np.clip(total, 0.0, 1.0)


def _fitness(model: CameraModel, variables: Sequence[Variable], rows: Array) -> Array:
    """(rows,) posterior mean of cameras given by a number in 0..1 for each variable."""
    cameras = [camera_at(variables, row) for row in rows]
    feasible = np.array([not model.record.broken(camera) for camera in cameras])
    values = np.zeros(len(cameras))
    if feasible.any():
        found = model.posterior([camera for camera, ok in zip(cameras, feasible, strict=True) if ok]).mean
        values[feasible], values[~feasible] = found, found.mean()
    return values


def _curve(model: CameraModel, variable: Variable, best: Values) -> list[dict[str, Any]]:
    """Posterior mean and interval along a variable, all else as in the best camera; parts best first."""
    if isinstance(variable, CatalogChoice | Categorical):
        count = len(variable.rows if isinstance(variable, CatalogChoice) else variable.values)
        places = (np.arange(count) + 0.5) / count
    else:
        places = np.linspace(0, 1, STEPS + 1)
    values = list(
        {content_key(value): value for value in (value_at(variable, float(at)) for at in places)}.values()
    )
    cameras = [{**best, variable.name: value} for value in values]
    feasible = [i for i, camera in enumerate(cameras) if not model.record.broken(camera)]
    if not feasible:
        return []
    posterior = model.posterior([cameras[i] for i in feasible])
    half = float(ndtri((1 + LEVEL) / 2)) * posterior.sd
    points = [
        {"value": _shown(values[i]), "mean": float(mean), "low": float(mean - h), "high": float(mean + h)}
        for i, mean, h in zip(feasible, posterior.mean, half, strict=True)
    ]
    return sorted(points, key=lambda point: -point["mean"]) if isinstance(variable, CatalogChoice) else points


def _shown(value: Any) -> Any:
    return value["name"] if isinstance(value, Mapping) else value
