"""Scrambled Sobol points."""

from __future__ import annotations

import json

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_framework.contracts import Evaluated
from tacos_framework.variables.design_space import Categorical, Continuous, DesignSpace
from tacos_plugins.optimizers.random_search import RandomSearch
from tacos_plugins.optimizers.sobol import Sobol
from tests.optimizers.landscapes import MIXED, SMOOTH, search


def make(space: DesignSpace = SMOOTH, seed: int = 1, **config) -> Sobol:
    return Sobol(Sobol.Config(**config), space=space, rng=np.random.default_rng(seed))


def drawn(optimizer: Sobol) -> np.ndarray:
    """(candidates, genes) of a whole run."""
    genes = []
    while optimizer.stop() is None:
        asked = optimizer.ask()
        genes += [candidate.genes for candidate in asked]
        optimizer.tell([Evaluated(candidate, 0.0) for candidate in asked])
    return np.array(genes)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32), power=st.integers(0, 7), batch=st.integers(1, 40))
def test_every_part_of_every_range_holds_one_point(seed, power, batch):
    count = 2**power
    genes = drawn(make(seed=seed, evaluations=count, batch=batch))
    cells = np.sort(np.floor(genes / 10 * count).astype(int), axis=0)
    np.testing.assert_array_equal(cells, np.tile(np.arange(count)[:, None], 4))


def test_choices_come_equally_often():
    space = DesignSpace([Categorical("lens", tuple("abcdefgh")), Continuous("a", 0, 1, "m")])
    genes = drawn(make(space, evaluations=64))
    np.testing.assert_array_equal(np.bincount(genes[:, 0].astype(int)), np.full(8, 8))


def test_it_covers_the_space_better_than_random_draws():
    """Largest empty distance over a grid, 64 points in three dimensions: the median of seeds."""
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 9)] * 3), axis=-1).reshape(-1, 3)
    scale = np.array([[-1, 0, 1], [2, 100, 29]])

    def hole(genes: np.ndarray) -> float:
        unit = (genes - scale[0]) / scale[1]
        return float(np.linalg.norm(grid[:, None] - unit[None], axis=2).min(axis=1).mean())

    spread = [hole(drawn(make(MIXED, seed, evaluations=64))) for seed in range(15)]
    random = [
        hole(
            drawn(
                RandomSearch(
                    RandomSearch.Config(evaluations=64), space=MIXED, rng=np.random.default_rng(seed)
                )
            )
        )
        for seed in range(15)
    ]
    assert np.median(spread) < np.median(random)


def test_64_evaluations_always_find_a_window_of_a_64th_where_random_search_often_does_not():
    space = DesignSpace([Continuous("baseline_m", 0, 8, "m"), Continuous("hfov_deg", 0, 80, "deg")])

    def in_window(candidate) -> float:
        baseline_m, hfov_deg = candidate.genes
        return float(5 <= baseline_m < 6 and 20 <= hfov_deg < 30)

    def random(seed: int) -> RandomSearch:
        return RandomSearch(RandomSearch.Config(evaluations=64), space=space, rng=np.random.default_rng(seed))

    assert all(search(make(space, seed, evaluations=64), in_window) == 1 for seed in range(30))
    assert sum(search(random(seed), in_window) == 1 for seed in range(30)) < 26


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 2**32), batch=st.integers(1, 9), rounds=st.integers(0, 6))
def test_resumed_it_goes_on_where_it_was(seed, batch, rounds):
    unbroken = make(seed=seed, evaluations=30, batch=batch)
    for _ in range(rounds):
        if unbroken.stop() is None:
            unbroken.tell([Evaluated(candidate, None) for candidate in unbroken.ask()])
    resumed = make(seed=0, evaluations=30, batch=batch)
    resumed.restore(json.loads(json.dumps(unbroken.state())))
    np.testing.assert_array_equal(drawn(resumed), drawn(unbroken))
