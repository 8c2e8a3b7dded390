"""Scores of cameras that were never simulated, estimated from a study's own images."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tacos_framework import ScoredEpisode, StudyRecord, Values, content_key
from tacos_plugins.surrogate.fitness_posterior import FitnessPosterior
from tacos_plugins.surrogate.grey_box import GreyBox, Observation

Array = NDArray[np.float64]

TIME = "generation"
"""The coordinate along which scores drift where tasks learn during the study."""

DRAWS = 4000
"""Joint draws that probabilities are counted over: good to 1 % of probability."""

LEVEL = 0.95
"""Of credible intervals."""


@dataclass(frozen=True, eq=False)
class Point:
    """A camera, and the coordinates its images depend on."""

    camera: Values
    coordinates: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class CameraModel:
    """The fitness of any camera of the study, with what is not known of it."""

    record: StudyRecord
    box: GreyBox
    """One Gaussian process for each score, of everything the study scored."""

    @classmethod
    def fit(cls, record: StudyRecord) -> CameraModel:
        """Learn from every episode of the search, the finalists and the test."""
        problem = record.problem
        box = GreyBox.fit(
            list(_observations(record)),
            problem.fitness,
            problem.scales,
            problem.depends_on,
            drift=TIME if problem.weights_learn else None,
        )
        return cls(record, box)

    def posterior(self, cameras: Sequence[Values]) -> FitnessPosterior:
        """Posterior of the fitness of cameras, as plain values of their variables."""
        return self.posterior_of([self.point(camera) for camera in cameras])

    def point(self, camera: Values) -> Point:
        """A camera that is asked about more than once."""
        return Point(camera, self.record.coordinates(camera))

    def posterior_of(self, points: Sequence[Point]) -> FitnessPosterior:
        """As `posterior`, for cameras whose coordinates are known."""
        return self.box.posterior([point.coordinates for point in points])

    def mean_scores(self, cameras: Sequence[Values]) -> dict[str, Array]:
        """(cameras,) posterior means of ``fitness`` and of each of its scores, over scenarios weighted."""
        posterior, fitness = self.posterior(cameras), self.record.problem.fitness
        means = posterior.score_means()
        for score in [term.score for term in fitness.terms] if fitness.scenarios else ():
            by_scenario = [(means[f"{n}/{score}"], w) for n, w in fitness.mean_weights.items()]
            means[score] = np.sum([mean * weight for mean, weight in by_scenario], axis=0)
        return {**means, "fitness": posterior.mean}

    def draws(self, cameras: Sequence[Values]) -> Array:
        """(DRAWS, cameras) joint draws of the fitness; the same whenever they are drawn."""
        return self.draws_of([self.point(camera) for camera in cameras], DRAWS)

    def draws_of(self, points: Sequence[Point], count: int) -> Array:
        """(count, points) joint draws of the fitness; the same whenever they are drawn."""
        return self.posterior_of(points).draws(count, np.random.default_rng(self.record.recipe.seed))

    def feasible(self, cameras: Sequence[Values]) -> list[Point]:
        """Those that break no constraint."""
        return [self.point(camera) for camera in cameras if not self.record.broken(camera)]

    @cached_property
    def scored(self) -> dict[str, Values]:
        """Every camera that was scored and breaks no constraint, by content key."""
        found: dict[str, Values] = {}
        for episode in self.record.episodes:
            found.setdefault(content_key(episode.camera), episode.camera)
        return {key: camera for key, camera in found.items() if not self.record.broken(camera)}

    def episodes_of(self, camera: Values) -> list[ScoredEpisode]:
        """Episodes that a camera was scored on."""
        return self._episodes.get(content_key(camera), [])

    @cached_property
    def _episodes(self) -> dict[str, list[ScoredEpisode]]:
        found: dict[str, list[ScoredEpisode]] = {}
        for episode in self.record.episodes:
            found.setdefault(content_key(episode.camera), []).append(episode)
        return found


def _observations(record: StudyRecord) -> list[Observation]:
    observations = []
    coordinates: dict[str, Mapping[str, float]] = {}
    for episode in record.episodes:
        key = content_key(episode.camera)
        if key not in coordinates:
            coordinates[key] = record.coordinates(episode.camera)
        point = dict(coordinates[key])
        if record.problem.weights_learn:
            point[TIME] = float(episode.generation)
        observations.append(Observation(point, episode.episode, episode.scores))
    return observations


def interval(draws: Array) -> tuple[Array, Array]:
    """Ends of the central credible interval of each column."""
    low, high = np.quantile(draws, [(1 - LEVEL) / 2, (1 + LEVEL) / 2], axis=0)
    return low, high
