"""Jobs for other processes: plain data, which can be pickled."""

from __future__ import annotations

import logging
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework.cache import content_key
from tacos_framework.camera.clipping import Exposed, exposed
from tacos_framework.contracts import State
from tacos_framework.formation import shown
from tacos_framework.simulation.episodes import EpisodeSpec
from tacos_framework.simulation.evaluation import Evaluation
from tacos_framework.simulation.simulation import Simulation
from tacos_framework.values import FrameBatch

log = logging.getLogger(__name__)

Result = TypeVar("Result", covariant=True)


class Job(Protocol[Result]):
    """Something to do with a simulation, in whatever process it lives."""

    def run(self, simulation: Simulation) -> Result: ...

    def lost(self, reason: str) -> Result:
        """The result of a job whose process dies or hangs, again and again."""
        ...


@dataclass(frozen=True)
class ScoreJob:
    """Train the trainable tasks on a candidate's frames, then score it on other frames.

    Where the episodes are but a part of those it is to be scored by (``partial``), the fitness is left open.
    """

    values: Mapping[str, Any]
    episodes: tuple[EpisodeSpec, ...]
    states: Mapping[str, State] = field(default_factory=dict)
    training: EpisodeSpec | None = None
    partial: bool = False

    @property
    def affinity(self) -> Hashable | None:
        """The world it begins in; where it trains, also the candidate, whose frames may be at hand."""
        if self.training is not None:
            return _frames(self.values, self.training)
        first = next(iter(self.episodes), None)
        return first and first.world

    def run(self, simulation: Simulation) -> Evaluation:
        return simulation.evaluate(
            self.values, self.episodes, states=self.states, training=self.training, partial=self.partial
        )

    def lost(self, reason: str) -> Evaluation:
        return Evaluation(values=self.values, failed=reason)


@dataclass(frozen=True)
class PrepareJob:
    """Render the frames that tasks will train on, while other workers train or score."""

    values: Mapping[str, Any]
    training: EpisodeSpec

    @property
    def affinity(self) -> Hashable:
        """The frames of the training to come."""
        return _frames(self.values, self.training)

    def run(self, simulation: Simulation) -> Evaluation:
        """The time it took; what fails here fails where it is needed, and is told there."""
        try:
            return simulation.prepare(self.values, self.training)
        except Exception as error:  # noqa: BLE001 - nothing is lost but time
            return self.lost(f"{type(error).__name__}: {error}")

    def lost(self, reason: str) -> Evaluation:
        log.info("no training was prepared: %s", reason)
        return Evaluation(values=self.values)


def _frames(values: Mapping[str, Any], training: EpisodeSpec) -> Hashable:
    """Origin of the frames to train on."""
    return training.world, content_key(values)


@dataclass(frozen=True)
class BuildJob:
    """Build a world and light it, for whoever needs it later; any camera will do to look at it."""

    values: Mapping[str, Any]
    episode: EpisodeSpec

    @property
    def affinity(self) -> Hashable:
        return self.episode.world

    def run(self, simulation: Simulation) -> None:
        """Take a frame; what fails here fails where it is needed, and is told there."""
        try:
            simulation.sample(self.values, self.episode, 0.0)
        except Exception as error:  # noqa: BLE001 - nothing is lost but time
            self.lost(f"{type(error).__name__}: {error}")

    def lost(self, reason: str) -> None:
        log.info("a world was not built ahead: %s", reason)


@dataclass(frozen=True, eq=False)
class SampleFrame:
    """A frame as an (H, W, C) uint8 picture, and how it is exposed."""

    picture: NDArray[np.uint8]
    exposed: Exposed


@dataclass(frozen=True)
class SampleJob:
    """Take sample frames with a camera, to look at: encoded for a display, here and not by whoever waits."""

    values: Mapping[str, Any]
    episode: EpisodeSpec
    at: tuple[float, ...]

    @property
    def affinity(self) -> Hashable:
        return self.episode.world

    def run(self, simulation: Simulation) -> list[SampleFrame]:
        """For each position in 0..1 along the episode a frame of the rig's first camera."""
        try:
            return [_shown(simulation.sample(self.values, self.episode, position)) for position in self.at]
        except Exception as error:
            if simulation.plan.recipe.study.on_error == "stop":
                raise
            return self.lost(f"{type(error).__name__}: {error}")

    def lost(self, reason: str) -> list[SampleFrame]:
        log.warning("no sample frames of %s: %s", dict(self.values), reason)
        return []


def _shown(batch: FrameBatch) -> SampleFrame:
    taken = batch.images[0][0], batch.black_level_dn, batch.white_level_dn
    return SampleFrame(shown(batch)[0][0], exposed(*taken))
