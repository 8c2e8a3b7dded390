"""Bayesian optimization of little: few candidates, few variables, few that matter, nothing free."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tacos_framework.contracts import DesignProblem, Evaluated
from tacos_framework.variables.design_space import Continuous, DesignSpace
from tacos_plugins.optimizers.physical_gp.optimizer import PhysicalGp
from tests.optimizers.camera_problem import FITNESS, CameraProblem
from tests.optimizers.physical_gp_runs import SMALL, finish, finish_and_take, make


def test_a_space_of_few_candidates_is_searched_through_and_said_to_be():
    optimizer = make(SMALL, evaluations=50, starts=3)
    history = finish(optimizer, lambda c: Evaluated(c, float(c.genes[0])))
    assert sorted(c.genes for r in history for c in r) == sorted(
        (n, k) for n in (1.0, 2.0, 3.0) for k in (0.0, 1.0)
    )
    assert optimizer.stop() == "all 6 candidates there are were evaluated"
    assert [c.genes[0] for c in optimizer.recommend(2)] == [3.0, 3.0]


def test_a_space_of_few_candidates_is_scored_on_every_scene():
    problem = DesignProblem(FITNESS, 3, lambda c: {"n": c.genes[0]}, lambda _: {})
    scores = {"orb.inliers": 3.0, "orb.ratio": 0.1, "door.seen": 1.0}

    def evaluate(asked):
        own = {**scores, "orb.inliers": asked.candidate.genes[0]}
        return Evaluated(asked.candidate, 1.0, episodes=dict.fromkeys(asked.episodes, own))

    history = finish(make(SMALL, evaluations=50, starts=3, problem=problem), evaluate)
    pairs = [(a.candidate, a.episodes) for r in history for a in r]
    assert len(pairs) == len(set(pairs)) == 6 * 3


def test_a_product_that_leaves_nothing_free_is_searched_all_the_same():
    optimizer = make(DesignSpace([]), evaluations=3)
    assert len(finish(optimizer, lambda c: Evaluated(c, 1.0))) == 1
    assert optimizer.recommend(3) == [DesignSpace([]).decode([])]


def test_one_variable_is_enough():
    """A product whose pitch alone is free."""
    camera = CameraProblem(1)
    space = camera.space.fix(["focal_length_mm", "sensor"])
    problem = replace(
        camera.problem,
        coordinates=lambda c: {"pitch_deg": c.genes[0], "hfov_deg": 80.0},
        broken=lambda _: {},
    )
    scores = lambda c: {"orb.inliers": 100 - abs(c.genes[0] + 12), "orb.ratio": 0.5, "door.seen": 0.5}  # noqa: E731

    def evaluate(asked):
        own = scores(asked.candidate)
        return Evaluated(asked.candidate, FITNESS.value(own), episodes=dict.fromkeys(asked.episodes, own))

    optimizer = make(space, problem=problem, evaluations=16)
    finish(optimizer, evaluate)
    assert optimizer.recommend(1)[0].values["pitch_deg"] == pytest.approx(-12, abs=2)


def test_a_dozen_settings_of_which_two_matter():
    space = DesignSpace([Continuous(f"isp.s{i}", 0, 1, "1") for i in range(12)])

    def worth(c):
        return -((c.genes[3] - 0.7) ** 2) - (c.genes[8] - 0.2) ** 2

    found = [finish_and_take(make(space, seed, evaluations=30), worth) for seed in range(3)]
    assert np.median([-worth(c) for c in found]) < 0.05


def test_where_nothing_keeps_the_constraints_it_says_which_one_is_broken_and_asks_nothing():
    problem = DesignProblem(FITNESS, 2, lambda _: {"x": 0.0}, lambda _: {"hfov_deg": 5.0})
    optimizer = make(problem=problem)
    expected = "no candidate was found that keeps all constraints; most break that on hfov_deg"
    assert optimizer.stop() == expected
    assert optimizer.ask() == []
    assert optimizer.recommend(3) == []


@pytest.mark.parametrize(("variables", "starts"), [(1, 4), (2, 6), (3, 8), (5, 8)])
def test_a_space_of_few_variables_needs_few_starts(variables, starts):
    space = DesignSpace([Continuous(f"x{i}", 0, 1) for i in range(variables)])
    optimizer = PhysicalGp(PhysicalGp.Config(evaluations=40), space=space, rng=np.random.default_rng(1))
    assert len(optimizer.ask()) == starts
