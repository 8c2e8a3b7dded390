"""The fitness of any camera, from a Gaussian process of each score and the weights that are known."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Fitness, ScoreScale
from tacos_plugins.surrogate.coordinates import CoordinateSystem
from tacos_plugins.surrogate.fitness_posterior import FitnessPosterior, score_names
from tacos_plugins.surrogate.gaussian_process import Inputs
from tacos_plugins.surrogate.kernel import NO_EPISODE, Hyperparameters
from tacos_plugins.surrogate.score_model import ScoreModel
from tacos_plugins.surrogate.transforms import TRANSFORMS

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Observation:
    """Scores of a camera in one scene."""

    coordinates: Mapping[str, float]
    """Coordinates of its images, by name; finite numbers. One that is not known is left out."""
    episode: Hashable
    """The scene; observations of equal ones share its effect. None where it is not known."""
    scores: Mapping[str, float]
    """By ``node.score``, or ``scenario/node.score`` where there are several scenarios. A score without
    meaning in this scene is left out.
    """


@dataclass(frozen=True, eq=False)
class GreyBox:
    """A posterior of the fitness at any point, learnt score by score.

    The fitness is a known weighted sum; only the scores have to be learnt, each with its own length scales,
    noise and transform. Build one with :meth:`fit`.

    >>> from tacos_framework.fitness import FitnessTerm
    >>> fovs_deg = np.linspace(30, 120, 12)
    >>> observations = [
    ...     Observation({"hfov_deg": x}, scene, {"features.inliers": 100 - (x - 80) ** 2 / 40 + 9 * scene})
    ...     for x in fovs_deg
    ...     for scene in (0, 1)
    ... ]
    >>> fitness = Fitness((FitnessTerm("features.inliers", 0.01),))
    >>> model = GreyBox.fit(observations, fitness, {"features.inliers": "count"})
    >>> posterior = model.posterior([{"hfov_deg": 82.0}, {"hfov_deg": 40.0}])
    >>> bool(abs(posterior.mean[0] - 1.04) < 0.02), bool(posterior.mean[0] > posterior.mean[1] + 0.3)
    (True, True)
    """

    fitness: Fitness
    """Weights of the scores and of the scenarios."""
    system: CoordinateSystem
    """The coordinates and their ranges."""
    models: Mapping[str, ScoreModel]
    """A model of each score of each scenario, by name."""
    degenerate: str | None = None
    """Why the observations allow no conclusion, in a sentence; None where they do."""

    @classmethod
    def fit(
        cls,
        observations: Sequence[Observation],
        fitness: Fitness,
        scales: Mapping[str, ScoreScale] | None = None,
        depends_on: Mapping[str, Sequence[str]] | None = None,
        *,
        drift: str | None = None,
        system: CoordinateSystem | None = None,
        start: Mapping[str, Hyperparameters] | None = None,
        fixed: bool = False,
    ) -> GreyBox:
        """A model of each score of the fitness.

        - `observations`: what came out, in the order in which it was observed.
        - `fitness`: which scores count, and how much.
        - `scales`, `depends_on`: as `tacos_framework.contracts.DesignProblem` has them, by ``node.score``.
        - `drift`: the coordinate that is time, where tasks learn meanwhile. Predictions are for the latest.
        - `system`: the coordinates and their ranges; those of the observations by default.
        - `start`: hyperparameters to begin from, by score.
        - `fixed`: whether to keep those of `start` as they are, which is quicker.
        """
        points = [observation.coordinates for observation in observations]
        system = system or CoordinateSystem.spanning(points)
        rows = system.rows(points)
        episodes = _numbered([observation.episode for observation in observations])
        times = rows[:, system.names.index(drift)] if drift is not None else None
        inputs = Inputs(rows, episodes, times)
        models = {}
        for name in score_names(fitness):
            score = name.rpartition("/")[2]
            reported = [i for i, observation in enumerate(observations) if name in observation.scores]
            if not reported:
                continue
            columns = _columns(system, (depends_on or {}).get(score), drift)
            taken = inputs.take(np.array(reported))
            models[name] = ScoreModel.fit(
                Inputs(taken.points[:, columns], taken.episodes, taken.times),
                np.array([float(observations[i].scores[name]) for i in reported]),
                TRANSFORMS[(scales or {}).get(score, "real")],
                columns=columns,
                start=(start or {}).get(name),
                fixed=fixed,
            )
        return cls(fitness, system, models, _degenerate(observations, fitness))

    @property
    def hyperparameters(self) -> dict[str, Hyperparameters]:
        return {name: model.process.hyperparameters for name, model in self.models.items()}

    def posterior(self, points: Sequence[Mapping[str, float]]) -> FitnessPosterior:
        """Posterior of the fitness at points, averaged over scenes."""
        return self.posterior_at(self.system.rows(points))

    def posterior_at(self, rows: Array) -> FitnessPosterior:
        """As :meth:`posterior`, for rows that :attr:`system` has scaled."""
        return FitnessPosterior.at(rows, self.fitness, self.models)


def _numbered(episodes: Sequence[Hashable]) -> NDArray[np.int64]:
    """A number for each scene, `NO_EPISODE` where it is None."""
    numbers: dict[Hashable, int] = {}
    return np.array(
        [NO_EPISODE if e is None else numbers.setdefault(e, len(numbers)) for e in episodes], dtype=np.int64
    )


def _columns(system: CoordinateSystem, wanted: Sequence[str] | None, drift: str | None) -> NDArray[np.int64]:
    """Coordinates of a score: those it names, where there are any of them, or all."""
    named = [i for i, name in enumerate(system.names) if wanted is None or name in wanted]
    kept = named or range(len(system.names))
    return np.array([i for i in kept if system.names[i] != drift], dtype=np.int64)


def _degenerate(observations: Sequence[Observation], fitness: Fitness) -> str | None:
    """Why these observations tell nothing of which camera is better, in a sentence."""
    if not observations:
        return "nothing was observed"
    values = {
        name: [o.scores[name] for o in observations if name in o.scores] for name in score_names(fitness)
    }
    if missing := [name for name, found in values.items() if not found]:
        return f"no episode gave a value for {', '.join(missing)}, which the fitness needs"
    if all(not any(found) for found in values.values()):
        return f"all scores of the {len(observations)} observations are zero"
    if all(min(found) == max(found) for found in values.values()):
        return f"all {len(observations)} observations have equal scores"
    first = observations[0].coordinates
    if all(observation.coordinates == first for observation in observations):
        return f"all {len(observations)} observations are of cameras with equal coordinates"
    return None
