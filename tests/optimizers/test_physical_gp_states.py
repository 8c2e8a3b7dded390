"""Bayesian optimization resumed."""

from __future__ import annotations

import json

from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_framework.contracts import Evaluated
from tacos_framework.variables.design_space import Categorical, Continuous, DesignSpace
from tests.optimizers.camera_problem import CameraProblem
from tests.optimizers.physical_gp_runs import finish, make


@settings(max_examples=8, deadline=None)
@given(
    seed=st.integers(0, 2**32),
    fitness=st.lists(st.none() | st.floats(-1e6, 1e6), min_size=1, max_size=20),
    after=st.integers(0, 4),
)
def test_any_fitness_can_be_resumed_bit_by_bit(seed, fitness, after):
    space = DesignSpace([Continuous("a", 0, 1, "m"), Categorical("lens", ("wide", "normal", "tele"))])

    def tell(optimizer):
        optimizer.tell([Evaluated(c, fitness[int(c.key, 16) % len(fitness)]) for c in optimizer.ask()])

    unbroken, resumed = make(space, seed, evaluations=12, starts=4), make(space, 0, evaluations=12, starts=4)
    for _ in range(after):
        tell(unbroken)
    resumed.restore(json.loads(json.dumps(unbroken.state(), allow_nan=False)))
    while unbroken.stop() is None:
        assert [c.genes for c in resumed.ask()] == [c.genes for c in unbroken.ask()]
        tell(resumed)
        tell(unbroken)
    assert resumed.stop() == unbroken.stop()
    assert resumed.recommend(2) == unbroken.recommend(2)


def test_scores_of_scenes_are_resumed_too():
    unbroken, resumed = CameraProblem(3), CameraProblem(3)
    one = make(unbroken.space, 1, unbroken.problem, evaluations=14)
    other = make(resumed.space, 2, resumed.problem, evaluations=14)
    for _ in range(2):
        one.tell([unbroken.evaluate(each) for each in one.ask()])
    other.restore(json.loads(json.dumps(one.state(), allow_nan=False)))
    resumed.rng.bit_generator.state = unbroken.rng.bit_generator.state
    assert finish(one, unbroken.evaluate) == finish(other, resumed.evaluate)
