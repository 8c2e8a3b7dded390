"""The optimizer as its tests make it and run it to its end."""

from __future__ import annotations

import numpy as np

from tacos_framework.contracts import Asked, DesignProblem, Evaluated
from tacos_framework.variables.design_space import Categorical, DesignSpace, Integer
from tacos_plugins.optimizers.physical_gp.optimizer import PhysicalGp
from tests.optimizers.landscapes import MIXED

SMALL = DesignSpace([Integer("n", 1, 3), Categorical("lens", ("wide", "tele"))])


def make(
    space: DesignSpace = MIXED, seed: int = 1, problem: DesignProblem | None = None, **config
) -> PhysicalGp:
    return PhysicalGp(
        PhysicalGp.Config(**config), space=space, rng=np.random.default_rng(seed), problem=problem
    )


def candidates_of(asked) -> list:
    return [each.candidate if isinstance(each, Asked) else each for each in asked]


def finish(optimizer: PhysicalGp, evaluate) -> list:
    """Ask and tell until it stops; all that was asked."""
    history = []
    while optimizer.stop() is None:
        asked = optimizer.ask()
        history.append(asked)
        optimizer.tell([evaluate(each) for each in asked])
    return history


def finish_and_take(optimizer, worth):
    finish(optimizer, lambda c: Evaluated(c, worth(c)))
    return optimizer.recommend(1)[0]
