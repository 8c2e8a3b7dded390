"""Conformance suite of perception tasks, and of those that learn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from safetensors.numpy import load, save

from tacos_framework.contracts import Budget, Scores, State
from tacos_framework.formation import frames_for
from tacos_framework.testing.component import ComponentConformance
from tacos_framework.testing.fingerprint import fingerprint
from tacos_framework.testing.samples import part_of, sample_frames, sample_rig
from tacos_framework.values import FrameBatch


class TaskConformance(ComponentConformance):
    """The suite for tasks of one port that takes frames; override `frames` to give them something to see."""

    kind: ClassVar[str] = "task"

    def frames(self) -> FrameBatch:
        """One episode of at least four frames in which every score of the task has meaning."""
        return sample_frames(sample_rig(width_px=320, height_px=240))

    def state(self, task: Any) -> State | None:
        return None

    def score(self, batches: Sequence[FrameBatch]) -> Scores:
        """The scores of an episode that comes in these batches."""
        task = self.make()
        scorer = task.begin(state=self.state(task))
        for frames in batches:
            scorer.update(frames_for(task, frames))
        scores: Scores = scorer.scores()
        return scores

    def test_its_scores_are_named_and_finite(self) -> None:
        scores = self.score([self.frames()])
        assert set(scores) == set(self.component.scores)
        for name, value in scores.items():
            assert isinstance(value, float), f"{name} is a {type(value).__name__}, not a float"
            assert math.isfinite(value), f"{name} is {value}"

    def test_equal_frames_give_equal_scores(self) -> None:
        assert self.score([self.frames()]) == self.score([self.frames()])

    def test_batches_may_be_cut_anywhere(self) -> None:
        whole = self.frames()
        for cut in range(1, len(whole.episode)):
            assert self.score([batch(whole, 0, cut), batch(whole, cut, None)]) == self.score([whole])

    def test_scorers_do_not_share_what_they_saw(self) -> None:
        task, frames = self.make(), self.frames()
        used, fresh = (task.begin(state=self.state(task)) for _ in range(2))
        used.update(frames_for(task, frames))
        fresh.update(frames_for(task, frames))
        assert used.scores() == fresh.scores() == self.score([frames])

    def test_without_frames_it_scores_nothing_that_is_not_finite(self) -> None:
        assert all(math.isfinite(value) for value in self.score([]).values())

    def test_it_leaves_the_frames_as_they_were(self) -> None:
        frames = self.frames()
        before = fingerprint(frames)
        self.score([frames])
        assert fingerprint(frames) == before


class TrainableConformance(TaskConformance):
    """The suite for tasks that learn."""

    def state(self, task: Any) -> State:
        state: State = task.initial_state(rng=np.random.default_rng(1))
        return state

    def test_it_says_in_a_sentence_whether_it_is_untrained(self) -> None:
        if callable(untrained := getattr(self.make(), "untrained", None)):
            reason = untrained()
            assert reason is None or (isinstance(reason, str) and reason.strip())

    def fit(self, state: State) -> State:
        task, frames = self.make(), self.frames()
        batches = [batch(frames, 0, 2), batch(frames, 2, None)]
        fitted: State = task.fit(batches, state=state, budget=Budget(epochs=1), rng=np.random.default_rng(2))
        return fitted

    def test_its_state_is_plain_arrays(self) -> None:
        for name, array in self.state(self.make()).items():
            assert isinstance(name, str)
            assert isinstance(array, np.ndarray), f"{name} is a {type(array).__name__}"
            assert array.dtype.kind in "biuf", f"{name} has dtype {array.dtype}, which cannot be kept"

    def test_its_state_survives_being_kept(self) -> None:
        """States are kept as safetensors between generations, and with the results."""
        state = self.fit(self.state(self.make()))
        kept = load(save({name: np.ascontiguousarray(array) for name, array in state.items()}))
        assert fingerprint(dict(kept)) == fingerprint(dict(state))

    def test_scoring_leaves_the_state_as_it_was(self) -> None:
        task, frames = self.make(), self.frames()
        state = self.state(task)
        before = fingerprint(state)
        scorer = task.begin(state=state)
        scorer.update(frames_for(task, frames))
        scorer.scores()
        assert fingerprint(state) == before

    def test_the_task_itself_learns_nothing(self) -> None:
        """All that is learnt lies in the state, or candidates would not start alike."""
        task, frames = self.make(), self.frames()
        state = self.state(task)
        task.fit([frames], state=state, budget=Budget(epochs=1), rng=np.random.default_rng(2))
        scorer = task.begin(state=state)
        scorer.update(frames_for(task, frames))
        assert scorer.scores() == self.score([frames])

    def test_equal_generators_give_equal_initial_states(self) -> None:
        assert fingerprint(self.state(self.make())) == fingerprint(self.state(self.make()))

    def test_training_moves_the_state_and_leaves_the_old_one(self) -> None:
        state = self.state(self.make())
        before = fingerprint(state)
        fitted = self.fit(state)
        assert fingerprint(state) == before
        assert fingerprint(fitted) != before, "nothing was learnt"

    def test_training_keeps_names_and_shapes(self) -> None:
        state = self.state(self.make())
        shapes = {name: (array.shape, array.dtype) for name, array in state.items()}
        assert {name: (array.shape, array.dtype) for name, array in self.fit(state).items()} == shapes

    def test_training_repeats_itself(self) -> None:
        state = self.state(self.make())
        assert fingerprint(self.fit(state)) == fingerprint(self.fit(state))


def batch(frames: FrameBatch, start: int, stop: int | None) -> FrameBatch:
    return FrameBatch(
        part_of(frames.capture, start, stop),
        tuple(image[start:stop] for image in frames.images),
        frames.black_level_dn,
        frames.white_level_dn,
    )
