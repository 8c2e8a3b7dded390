"""Frames for tasks that learn, and the states they come to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from tacos_framework.cache import content_key
from tacos_framework.contracts import Budget, State
from tacos_framework.randomness import generator
from tacos_framework.simulation.episodes import EpisodeSpec
from tacos_framework.simulation.trial import Trial
from tacos_framework.values import Episode, FrameBatch

KEPT_BYTES = 512 * 2**20
"""Memory that frames may take between the passes of training over them [bytes]."""


def train(trial: Trial, task: str, state: State, spec: EpisodeSpec) -> tuple[State, int]:
    """Train a task on frames of a candidate.

    Parameters
    ----------
    trial
        The candidate.
    task
        The task node.
    state
        What the task has learned so far.
    spec
        The episode to learn from; its length is the task's own.

    Returns
    -------
    The new state, and how many images were rendered.
    """
    settings = trial.plan.recipe.nodes[task].train
    if settings is None or settings.weights == "frozen":
        return state, 0
    scene = trial.plan.graph.scene_of(task)
    spec = replace(spec, frames=settings.frames)
    with trial.clock.of(scene):
        episode = trial.episode(scene, spec)
    room = KEPT_BYTES if settings.epochs > 1 else 0  # nothing is kept for a pass that never comes
    frames = TrainingFrames(trial, scene, episode, spec, task, room)
    rng = generator(spec.seed, *spec.name, task, "fit")
    with trial.at_work(task, "training"):
        budget = Budget(settings.epochs, settings.settings)
        learnt = trial.components[task].fit(frames, state=state, budget=budget, rng=rng)
    return learnt, frames.images


@dataclass
class TrainingFrames:
    """What a task of one port learns from, the same in each iteration.

    The first batches stay for the passes to come, as many as fit into `room_bytes`; the rest are rendered
    anew, so that memory stays flat however long the episode is.
    """

    trial: Trial
    scene: str
    episode: Episode
    spec: EpisodeSpec
    task: str
    room_bytes: int
    images: int = 0
    _kept: list[FrameBatch] = field(default_factory=list)

    def __iter__(self) -> Iterator[FrameBatch]:
        yield from self._kept
        for inputs in self.trial.stream(self.scene, self.episode[self._begun :], self.spec, [self.task]):
            (batch,) = inputs[self.task].values()
            self.images += len(batch.episode) * len(batch.images)
            self._keep(batch)
            yield batch

    @property
    def _begun(self) -> int:
        """How many frames, counted from the first, are kept."""
        return sum(len(batch.episode) for batch in self._kept)

    def _keep(self, batch: FrameBatch) -> None:
        follows = batch.episode.first_frame == self.episode.first_frame + self._begun
        if follows and sum(kept.nbytes for kept in (*self._kept, batch)) <= self.room_bytes:
            self._kept.append(batch)


def state_key(states: Mapping[str, State]) -> str:
    """Content key of the states of trainable tasks."""
    return content_key({name: {k: np.asarray(v) for k, v in state.items()} for name, state in states.items()})
