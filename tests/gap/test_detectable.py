"""Detection limits: the least that would have shown."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
import pytest

from tacos_framework.settings import Settings, setting
from tacos_gap.attribution import COMPLEXITY_PENALTY
from tacos_gap.detectable import detection_limits
from tacos_gap.evidence import Label
from tacos_gap.problem import Problem

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
    limit = detection_limits(problem, {"slope": cls})["slope"]["slope"]
    by_gain = np.sqrt(2 * COMPLEXITY_PENALTY / (problem.weight * 2 * COUNT))
    by_change = 0.5  # the root of the least mean square that matters
    assert limit == pytest.approx(max(by_gain, by_change) ** (1 / cls.power), rel=1e-3)


def test_what_shows_nowhere_has_no_limit(problem):
    assert detection_limits(problem, {"idle": Idle}) == {}
