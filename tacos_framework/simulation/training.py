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
    frames = TrainingFrames(trial, scene, episode, spec, task)
    rng = generator(spec.seed, *spec.name, task, "fit")
    with trial.at_work(task, "training"):
        budget = Budget(settings.epochs, settings.settings)
        return trial.components[task].fit(frames, state=state, budget=budget, rng=rng), frames.images


@dataclass(frozen=True)
class TrainingFrames:
    """What a task of one port learns from; each iteration renders it anew, so that memory stays flat."""

    trial: Trial
    scene: str
    episode: Episode
    spec: EpisodeSpec
    task: str
    rendered: list[int] = field(default_factory=list)

    @property
    def images(self) -> int:
        """Images rendered by all iterations so far."""
        return sum(self.rendered)

    def __iter__(self) -> Iterator[FrameBatch]:
        for inputs in self.trial.stream(self.scene, self.episode, self.spec, [self.task]):
            (batch,) = inputs[self.task].values()
            self.rendered.append(len(batch.episode) * len(batch.images))
            yield batch


def state_key(states: Mapping[str, State]) -> str:
    """Content key of the states of trainable tasks."""
    return content_key({name: {k: np.asarray(v) for k, v in state.items()} for name, state in states.items()})
