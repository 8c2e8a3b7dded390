"""Frames for tasks that learn, and the states they come to."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tacos_framework.cache import content_key
from tacos_framework.contracts import Budget, State
from tacos_framework.formation import EpisodeDraws
from tacos_framework.randomness import generator
from tacos_framework.simulation.context import EvaluationContext
from tacos_framework.simulation.episodes import EpisodeSpec
from tacos_framework.values import Episode, FrameBatch

KEPT_BYTES = 512 * 2**20
"""Memory that frames may take between the passes of training over them [bytes]."""


@dataclass
class RenderedFrames:
    """The first batches of an episode, and how to go on behind them."""

    batches: list[FrameBatch] = field(default_factory=list)
    draws: dict[int, EpisodeDraws] = field(default_factory=dict)
    """Those of each scenario behind its last batch here, with what cameras and effects remember there."""


def train(
    contexts: Sequence[EvaluationContext],
    task: str,
    state: State,
    spec: EpisodeSpec,
    rendered: RenderedFrames | None = None,
) -> tuple[State, int]:
    """Train a task on frames of a candidate.

    - `contexts`: the candidate in each scenario, which take turns batch by batch.
    - `state`: what the task has learned so far.
    - `spec`: the episode to learn from; its length is the task's own.
    - `rendered`: its first frames, where they were rendered ahead (`rendered_ahead`).

    Returns: the new state, and how many images were rendered, those ahead included.
    """
    context = contexts[0]
    settings = context.plan.recipe.nodes[task].train
    if settings is None or settings.weights == "frozen":
        return state, 0
    room = KEPT_BYTES if settings.epochs > 1 else 0  # nothing is kept for a pass that never comes
    frames = _frames_of(contexts, task, spec, room)
    if rendered is not None:
        frames.begin_with(rendered)
    rng = generator(spec.seed, *spec.name, task, "fit")
    with context.at_work(task, "training"):
        budget = Budget(settings.epochs, settings.settings)
        learnt = context.components[task].fit(frames, state=state, budget=budget, rng=rng)
    return learnt, frames.images


def rendered_ahead(
    contexts: Sequence[EvaluationContext], task: str, spec: EpisodeSpec
) -> RenderedFrames | None:
    """The frames a task will learn from, from the first as many as fit into `KEPT_BYTES`.

    They follow from the candidate and the episode alone, not from what the task has learned until then.
    """
    settings = contexts[0].plan.recipe.nodes[task].train
    if settings is None or settings.weights == "frozen":
        return None
    return _frames_of(contexts, task, spec, KEPT_BYTES).until_full()


def _frames_of(
    contexts: Sequence[EvaluationContext], task: str, spec: EpisodeSpec, room_bytes: int
) -> TrainingFrames:
    """The batches that a task learns from in an episode, whose length is the task's own."""
    plan, clock = contexts[0].plan, contexts[0].clock
    settings, scene = plan.recipe.nodes[task].train, plan.graph.scene_of(task)
    spec = replace(spec, frames=settings.frames if settings else None)
    with clock.of(scene):
        episodes = [each.episode(scene, spec) for each in contexts]
    return TrainingFrames(contexts, scene, episodes, spec, task, room_bytes)


@dataclass
class TrainingFrames:
    """The batches of a task of one port, the same in each iteration; scenarios take turns batch by batch.

    The first batches stay for the passes to come, as many as fit into `room_bytes`; the rest are rendered
    anew, so that memory stays flat however long the episode is. A camera that controls its exposure, or an
    effect that settles, goes on behind them as it did the first time.
    """

    contexts: Sequence[EvaluationContext]
    scene: str
    episodes: Sequence[Episode]
    spec: EpisodeSpec
    task: str
    room_bytes: int
    images: int = 0
    _kept: RenderedFrames = field(default_factory=RenderedFrames)
    _full: bool = False

    def __iter__(self) -> Iterator[FrameBatch]:
        begun = len(self._kept.batches)
        draws = [
            self._kept.draws[i].as_now() if i in self._kept.draws else context.draws(self.spec)
            for i, context in enumerate(self.contexts)
        ]
        yield from self._kept.batches
        for turn, batch in self._rendered(begun, draws):
            self.images += len(batch.episode) * len(batch.images)
            self._keep(turn, batch, draws)
            yield batch

    def begin_with(self, rendered: RenderedFrames) -> None:
        """Take the first frames, which were rendered ahead; they count as if they had been rendered now."""
        self._kept = rendered
        self.images += sum(len(batch.episode) * len(batch.images) for batch in rendered.batches)

    def until_full(self) -> RenderedFrames:
        """Render the first batches, as many as there is room for."""
        for _ in self:
            if self._full:
                break
        return self._kept

    def _rendered(self, begun: int, draws: Sequence[EpisodeDraws]) -> Iterator[tuple[int, FrameBatch]]:
        """The batches after the first `begun`, the scenarios in turn; each with its number."""
        count = len(self.contexts)
        streams = [self._stream(i, self._kept.batches[i:begun:count], draws[i]) for i in range(count)]
        for turn in itertools.count(begun):
            inputs = next(streams[turn % count], None)
            if inputs is None:
                return
            (batch,) = inputs[self.task].values()
            yield turn, batch

    def _stream(
        self, scenario: int, kept: Sequence[FrameBatch], draws: EpisodeDraws
    ) -> Iterator[Mapping[str, Any]]:
        """The batches of a scenario made from the kept ones."""
        rest = self.episodes[scenario][sum(len(batch.episode) for batch in kept) :]
        return iter(self.contexts[scenario].stream(self.scene, rest, draws, [self.task]))

    def _keep(self, turn: int, batch: FrameBatch, draws: Sequence[EpisodeDraws]) -> None:
        """Keep a batch while there is room; only what follows on those kept already."""
        if turn != len(self._kept.batches) or self._full:
            return
        self._full = sum(kept.nbytes for kept in (*self._kept.batches, batch)) > self.room_bytes
        if not self._full:
            self._kept.batches.append(batch)
            scenario = turn % len(self.contexts)
            self._kept.draws[scenario] = draws[scenario].as_now()


def state_key(states: Mapping[str, State]) -> str:
    """Content key of the states of trainable tasks."""
    return content_key({name: {k: np.asarray(v) for k, v in state.items()} for name, state in states.items()})
