"""The task that learns."""

from __future__ import annotations

import numpy as np
from tacos_framework import Budget
from tacos_framework.testing import TrainableConformance
from tacos_framework.testing.samples import sample_frames

from tacos_example.free_distance import FreeDistance


class TestFreeDistance(TrainableConformance):
    component = FreeDistance


def test_training_lowers_the_error() -> None:
    task, frames, rng = FreeDistance(FreeDistance.Config()), sample_frames(), np.random.default_rng(1)
    state = task.initial_state(rng=rng)
    errors = []
    for _ in range(2):
        scorer = task.begin(state=state)
        scorer.update(frames)
        errors.append(scorer.scores()["log_error"])
        state = task.fit([frames], state=state, budget=Budget(), rng=rng)
    assert errors[1] < 0.01 < errors[0]
