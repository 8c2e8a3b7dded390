"""Detection limits: the least that would have shown."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
import pytest

from tacos_framework.settings import Settings, setting
from tacos_gap.answer.detection_limits import detection_limits
from tacos_gap.attribution import COMPLEXITY_PENALTY
from tacos_gap.evidence import Label
from tacos_gap.inference.problem import Problem
from tacos_gap.inference.significance import block_test, least_significant
from tacos_gap.inference.unknown import SLACK, block_index

COUNT = 400


class Slope:
    """An effect that acts in proportion."""

    class Config(Settings):
        slope: float = setting(0.0, help="Slope.")

    neutral: ClassVar = {"slope": 0.0}
    initial_guesses: ClassVar = ({"slope": 5.0},)
    power = 1

    def __init__(self, config: Config) -> None:
        self.config = config


class Scatter(Slope):
    """An effect that adds in squares, as noise does."""

    power = 2


class Idle(Slope):
    """An effect that shows nowhere."""

    power = 0


class Ramp:
    """Evidence that a slope shows in, its noise floor 1."""

    def __init__(self, seed: int):
        rng = np.random.default_rng(seed)
        self.labels = [Label(f"flat {seed}", "flat", "ramp", "optics", {"n": n}) for n in range(COUNT)]
        self.null_replicates = rng.normal(0, 1, (16, COUNT))
        self._noise = rng.normal(0, 1, COUNT)

    def residual(self, effects: Sequence[Any], draws: int = 1) -> np.ndarray:
        change = sum(e.config.slope**e.cls.power if e.cls.power else 0.0 for e in effects)
        return np.asarray(self._noise - change)


@pytest.fixture
def problem() -> Problem:
    return Problem([Ramp(seed) for seed in range(2)])


@pytest.mark.parametrize("cls", [Slope, Scatter])
def test_the_limit_is_where_gain_and_change_reach_what_is_asked(problem, cls):
    limit = detection_limits(problem, {"slope": cls}, problem.null)["slope"]["slope"]
    by_gain = np.sqrt(2 * COMPLEXITY_PENALTY / (problem.weight * 2 * COUNT))
    by_change = 0.5  # the root of the least mean square that matters
    needed = least_significant(problem.null, problem.null_replicates, block_index(problem), 0.05, SLACK)
    significant = np.sqrt(needed.min() / COUNT)  # of either capture
    assert limit == pytest.approx(max(by_gain, by_change, significant) ** (1 / cls.power), rel=0.03)


def test_squares_grown_by_what_is_needed_are_just_significant(problem):
    """The reverse of the test, by the test itself: a block at its limit has the p-value asked for."""
    blocks = block_index(problem)
    quiet = 0.1 * problem.null  # equivalence margins make noise smaller than its floor
    needed = least_significant(quiet, problem.null_replicates, blocks, 0.05, SLACK)
    squares = np.sum(quiet[blocks == 0] ** 2) + needed[0]
    grown = np.where(blocks == 0, np.sqrt(squares / COUNT), quiet)
    found = block_test(grown, problem.null_replicates, blocks, SLACK).family_p_value()
    assert found == pytest.approx(0.05, rel=0.1)


def test_what_shows_nowhere_has_no_limit(problem):
    assert detection_limits(problem, {"idle": Idle}, problem.null) == {}
