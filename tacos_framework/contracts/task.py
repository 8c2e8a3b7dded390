"""Perception tasks, and those that learn."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, Protocol, get_args

import numpy as np
from numpy.typing import NDArray

from tacos_framework.contracts.optimizer import ScoreScale
from tacos_framework.settings import Settings
from tacos_framework.values import FrameBatch, Rig

Scores = Mapping[str, float]
"""Named numbers of one episode. A score without meaning there (no obstacle on the path) is left out."""

State = Mapping[str, NDArray[Any]]
"""State of a trainable task: named arrays, so that it can be kept without pickle."""


@dataclass(frozen=True)
class Budget:
    """Extent of a training: passes over the batches, and settings of the recipe's ``train:``.

    Where ``on_step`` is given, a task calls it with the losses of each step, by name.
    """

    epochs: int = 1
    settings: Mapping[str, Any] | None = None
    on_step: Callable[[Mapping[str, float]], None] | None = None


class Scorer(Protocol):
    """Scores one episode, batch by batch. The positional parameters of `update` are the task's ports."""

    def update(self, frames: FrameBatch) -> None:
        """Take in the next batch; batches come in order and do not overlap."""
        ...

    def scores(self) -> Scores:
        """The scores of all that was taken in; at least those named in ``Task.scores`` that have meaning."""
        ...


class Task(Protocol):
    """A perception task. ``scores`` names what its scorers report.

    `TaskBase` has the optional members.
    """

    Config: ClassVar[type[Settings]]
    scores: ClassVar[tuple[str, ...]]

    def begin(self, *, state: State | None) -> Scorer:
        """A scorer for one episode; `state` is None for tasks that do not learn."""
        ...


class Trainable(Protocol):
    """A task that learns. State goes in and comes out; the object itself keeps none.

    `TrainableBase` has the optional members.
    """

    scores: ClassVar[tuple[str, ...]]

    def begin(self, *, state: State | None) -> Scorer:
        """A scorer that uses `state`."""
        ...

    def initial_state(self, *, rng: np.random.Generator) -> State:
        """The state before any training of this study."""
        ...

    def fit(
        self, batches: Iterable[FrameBatch], *, state: State, budget: Budget, rng: np.random.Generator
    ) -> State:
        """A new state, trained on the batches; `state` itself is left as it was."""
        ...


def learns(task: type[Any]) -> bool:
    """True if a task class is `Trainable`."""
    return callable(getattr(task, "fit", None)) and callable(getattr(task, "initial_state", None))


Wanted = Literal["linear", "coded", "grey"]
"""See `TaskBase.wants`."""

WANTED_FILES: tuple[Wanted, ...] = get_args(Wanted)


class TaskBase:
    """Optional members of a `Task`, with their defaults."""

    lacks: Callable[[Rig], str | None] | None = None
    """Why it cannot judge a rig's cameras, in a sentence; used as that of a sensor."""
    lower_is_better: ClassVar[Collection[str]] = frozenset()
    """Those of the scores that are errors, of which reports call the smallest best."""
    score_meanings: ClassVar[Mapping[str, str]] = {}
    """Meaning of a score in a few words, where its name does not tell those who read a report."""
    score_scales: ClassVar[Mapping[str, ScoreScale]] = {}
    """The scores that are counts, and those that are shares between 0 and 1; the others may be any
    number."""
    margins: ClassVar[Mapping[str, float]] = {}
    """Differences of a score that do not matter on the job, in its unit. A study calls cameras equal by
    them unless its recipe has other ones; a score without has a margin of 0."""
    depends_on: ClassVar[Mapping[str, Sequence[str]]] = {}
    """The coordinates of the rig (`RigBuilder`) a score depends on, where it does not depend on all."""
    needs: Collection[str] = ()
    """The truth it is scored by, by the names in `TRUTHS`."""
    wants: Wanted | None = None
    """The files it works on, into which those that cameras deliver are turned: linear ones; 8 bits that are
    coded for a display; these in grey, one channel. It takes any that come if None."""
    frames_per_update: int = 1
    """How many frames it would have at a time, as a network on a GPU. It may be given more or fewer, and
    its scores must not depend on that."""


class TrainableBase(TaskBase):
    """Optional members of a `Trainable` task, with their defaults."""

    Training: ClassVar[type[Settings] | None] = None
    """The settings it takes from the recipe's ``train:`` through `Budget.settings`; those given are then
    checked with the recipe, before anything is computed."""
    untrained: Callable[[], str | None] | None = None
    """Why `initial_state` knows nothing yet, in a sentence that says where trained weights come from; None
    where it has been trained before. What is untrained is refused where a recipe freezes it."""
