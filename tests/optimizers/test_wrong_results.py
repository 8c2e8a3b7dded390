"""Results that no optimizer takes: of candidates it has not asked for, and of no finite fitness."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tacos_framework.contracts import Evaluated
from tacos_framework.plugins import Plugins
from tests.optimizers.landscapes import MIXED

SETTINGS = {"cma-es": {}, "optuna": {"batch": 2}, "physical-gp": {}, "ppo": {"evaluations": 8}}


@pytest.fixture(params=SETTINGS)
def optimizer(request: pytest.FixtureRequest) -> Any:
    optional = {"optuna": "optuna", "ppo": "stable_baselines3"}.get(request.param)
    if optional:
        pytest.importorskip(optional)
    made = Plugins.discover().resolve(f"optimizer.{request.param}")
    return made(made.Config(**SETTINGS[request.param]), space=MIXED, rng=np.random.default_rng(1))


@pytest.mark.parametrize("wrong", [float("nan"), float("inf")])
def test_a_fitness_that_is_no_finite_number_is_refused(optimizer, wrong):
    with pytest.raises(ValueError, match="not a finite number"):
        optimizer.tell([Evaluated(candidate, wrong) for candidate in optimizer.ask()])


def test_results_of_other_candidates_are_refused(optimizer):
    with pytest.raises(ValueError, match="candidates last asked"):
        optimizer.tell([Evaluated(candidate, 1.0) for candidate in optimizer.ask()[::-1]])
