"""PPO: that it learns, what it rewards, and that nothing global decides what it does."""

from __future__ import annotations

import json
import sys

import numpy as np
import pytest

from tacos_framework.contracts import Evaluated
from tacos_framework.errors import UserError
from tacos_framework.variables.design_space import Continuous, DesignSpace, Integer

pytest.importorskip("stable_baselines3", reason="the extra rl is not installed")

import torch

from tacos_plugins.optimizers.policy.designers import Designers, RewardScale
from tacos_plugins.optimizers.policy.ppo import Ppo

PLANE = DesignSpace([Continuous("x", 0, 10, "m"), Continuous("y", 0, 10, "m")])


def make(seed: int = 1, space: DesignSpace = PLANE, **config) -> Ppo:
    return Ppo(Ppo.Config(**config), space=space, rng=np.random.default_rng(seed))


def hill(candidate) -> float:
    return -float(np.sum((np.array(candidate.genes) - 8.0) ** 2))


def climb(search: Ppo, fitness=hill) -> list[float | None]:
    """The fitness of all candidates, in the order asked."""
    observed: list[float | None] = []
    while search.stop() is None:
        results = [Evaluated(candidate, fitness(candidate)) for candidate in search.ask()]
        observed += [result.fitness for result in results]
        search.tell(results)
    return observed


@pytest.mark.parametrize("config", [{}, {"reward": "gain", "discount": 0.9, "learning_rate": 3e-3}])
def test_the_policy_learns_where_to_go(config):
    found = climb(make(evaluations=960, steps=8, **config))
    early, late = np.mean(found[:96]), np.mean(found[-96:])
    drawn = np.mean([hill(PLANE.sample(rng)) for rng in [np.random.default_rng(0)] for _ in range(500)])
    assert late > 0.5 * early, "higher is better; all are below zero"
    assert late > 0.6 * drawn


def test_it_finds_better_cameras_than_random_draws_with_equal_evaluations():
    """Far from the middle in six dimensions, where draws hardly come."""
    space = DesignSpace([Continuous(name, 0, 10, "m") for name in "abcdef"])
    config = {"space": space, "evaluations": 800, "steps": 10, "learning_rate": 3e-3}
    for seed in (1, 2, 3):
        rng = np.random.default_rng(seed)
        drawn = max(hill(space.sample(rng)) for _ in range(800))
        assert max(climb(make(seed, **config))) > drawn


def test_a_stop_in_the_middle_of_a_rollout_changes_nothing():
    config = {"evaluations": 60, "rollout": 16, "steps": 5}
    unbroken = climb(make(**config))
    for rounds in (1, 3, 4, 6, 11):
        first = make(**config)
        for _ in range(rounds):
            first.tell([Evaluated(candidate, hill(candidate)) for candidate in first.ask()])
        second = make(seed=9, **config)
        second.restore(json.loads(json.dumps(first.state())))
        assert climb(second) == unbroken[4 * rounds :]


def test_nothing_global_is_seeded_or_drawn_from():
    config = {"evaluations": 40, "rollout": 16}
    torch.manual_seed(1)
    np.random.seed(1)  # noqa: NPY002 - to see that it does not matter
    first = climb(make(**config))
    before = (torch.get_rng_state(), np.random.get_state()[1].copy())  # noqa: NPY002
    torch.manual_seed(2)
    np.random.seed(2)  # noqa: NPY002
    assert climb(make(**config)) == first
    torch.manual_seed(1)
    np.random.seed(1)  # noqa: NPY002
    climb(make(**config))
    after = (torch.get_rng_state(), np.random.get_state()[1])  # noqa: NPY002
    assert torch.equal(before[0], after[0])
    np.testing.assert_array_equal(before[1], after[1])


def test_evaluations_are_spent_to_the_last_and_counted_as_asked():
    space = DesignSpace([Integer("n", 1, 2)])
    found = climb(make(space=space, evaluations=22, rollout=8), lambda candidate: float(candidate.genes[0]))
    assert len(found) == 22


def test_a_policy_whose_candidates_all_fail_goes_on():
    assert climb(make(evaluations=40, rollout=8), lambda _: None) == [None] * 40


def test_cameras_move_within_the_space_and_begin_anew_in_time():
    designers = Designers(2, 3, steps=2, step_size=0.5, rng=np.random.default_rng(1))
    designers.points = np.array([[0.9, 0.5, 0.1], [0.0, 1.0, 0.5]])
    to = designers.moved(np.array([[1.0, -2.0, 0.0], [0.5, 0.0, -0.5]], np.float32))
    np.testing.assert_allclose(to, [[1.0, 0.0, 0.1], [0.25, 1.0, 0.25]])
    np.testing.assert_allclose(designers.observe(to)[1], [-0.5, 1.0, -0.5])
    assert not designers.advance(to)
    assert designers.advance(to)
    assert not np.array_equal(designers.points, to)


def test_rewards_are_of_the_order_of_one_whatever_fitness_is_measured_in():
    values = np.random.default_rng(1).normal(size=200)
    for unit in (1e-6, 1.0, 1e6):
        scale = RewardScale()
        for value in values:
            scale.learn(value * unit)
        np.testing.assert_allclose(scale.scaled(2.0 * unit), (2.0 - values.mean()) / values.std(ddof=1))
        assert scale.scaled(1e9 * unit) == 10.0


def test_without_the_package_it_says_what_to_install(monkeypatch):
    monkeypatch.delitem(sys.modules, "tacos_plugins.optimizers.policy.learner", raising=False)
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    with pytest.raises((UserError, ModuleNotFoundError), match="stable_baselines3"):
        make()
