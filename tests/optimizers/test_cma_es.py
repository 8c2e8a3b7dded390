"""CMA-ES: what it finds, duplicates, failures, restarts, resume."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from tacos_framework.contracts import Evaluated
from tacos_framework.variables.design_space import Categorical, Continuous, DesignSpace, Integer
from tacos_plugins.optimizers.cma_es import BARREN_GENERATIONS, CmaEs
from tacos_plugins.optimizers.random_search import RandomSearch
from tacos_plugins.optimizers.restarts import Restarts
from tests.optimizers.landscapes import MIXED, SMOOTH, mixed, regret, search, smooth


def make(space: DesignSpace = SMOOTH, seed: int = 1, **config) -> CmaEs:
    return CmaEs(CmaEs.Config(**config), space=space, rng=np.random.default_rng(seed))


def draws(space: DesignSpace, seed: int, evaluations: int) -> RandomSearch:
    return RandomSearch(
        RandomSearch.Config(evaluations=evaluations), space=space, rng=np.random.default_rng(seed)
    )


def test_it_finds_a_smooth_optimum_in_200_evaluations_where_random_search_does_not():
    found = regret(lambda seed: make(seed=seed, evaluations=200), smooth, seeds=7)
    drawn = regret(lambda seed: draws(SMOOTH, seed, 200), smooth, seeds=7)
    assert found < 0.05
    assert drawn > 2.0


def test_it_finds_an_optimum_with_a_count_in_150_evaluations_where_random_search_does_not():
    found = regret(lambda seed: make(MIXED, seed, evaluations=150), mixed, seeds=7)
    drawn = regret(lambda seed: draws(MIXED, seed, 150), mixed, seeds=7)
    assert found < 0.05
    assert drawn > 0.15


def test_a_margin_keeps_counts_moving():
    """Once the Gaussian fits between two integers, only the margin can still leave them."""

    def misleading(candidate):  # the count matters little, and late
        a, n = candidate.genes
        return -100 * a**2 + (0.01 * n if abs(a) < 0.05 else 0.0)

    space = DesignSpace([Continuous("a", -1, 1, "m"), Integer("n", 1, 12)])
    reached = {}
    for margin in (0.0, 0.5):
        config = {"evaluations": 150, "margin": margin, "restarts": "none", "sigma": 0.05}
        reached[margin] = np.mean([search(make(space, seed, **config), misleading) for seed in range(10)])
    assert reached[0.5] > reached[0.0] + 0.01


def test_equal_candidates_of_a_generation_are_asked_once():
    optimizer = make(DesignSpace([Integer("n", 1, 3)]), evaluations=3)
    while optimizer.stop() is None:
        asked = optimizer.ask()
        assert len(set(asked)) == len(asked)
        optimizer.tell([Evaluated(candidate, candidate.genes[0]) for candidate in asked])
    assert optimizer.stop() == "3 different candidates were evaluated"


def test_a_space_without_anything_new_ends_the_search():
    optimizer = make(DesignSpace([Categorical("lens", ("wide", "tele"))]), evaluations=50)
    search(optimizer, lambda candidate: candidate.genes[0])
    assert optimizer.stop() == f"no new candidate was found in {BARREN_GENERATIONS} generations"


def test_a_product_that_leaves_nothing_free_ends_the_search():
    optimizer = make(DesignSpace([]), evaluations=50)
    assert len(optimizer.ask()) == 1
    assert search(optimizer, lambda _: 1.0) == 1.0
    assert optimizer.stop() is not None


def test_without_restarts_it_ends_when_converged():
    optimizer = make(MIXED, evaluations=100_000, restarts="none")
    search(optimizer, mixed)
    assert optimizer.stop() == "the search has converged, and restarts are off"


def test_restarts_escape_a_local_optimum():
    def two_peaks(candidate):
        genes = np.array(candidate.genes)
        return float(
            -min(np.sum((genes - 3) ** 2) + 3.0, 4 * np.sum((genes - 8) ** 2))
        )  # a wide peak of -3, a narrow one of 0

    found = regret(lambda seed: make(seed=seed, evaluations=1500), two_peaks, seeds=5)
    alone = regret(lambda seed: make(seed=seed, evaluations=1500, restarts="none"), two_peaks, seeds=5)
    assert found < 0.5
    assert alone == pytest.approx(3.0, abs=0.1)


def test_failures_rank_last_and_do_not_stop_it():
    """The best lies beside a region where everything fails."""

    def fenced(candidate):
        return None if candidate.genes[0] > 6.3 else smooth(candidate)

    assert regret(lambda seed: make(seed=seed, evaluations=250), fenced, seeds=5) < 0.1


def test_a_generation_that_fails_as_a_whole_is_left_behind():
    optimizer = make(evaluations=60)
    first = optimizer.ask()
    optimizer.tell([Evaluated(candidate, None) for candidate in first])
    second = optimizer.ask()
    optimizer.tell([Evaluated(candidate, None) for candidate in second])
    assert optimizer.ask()
    assert not set(optimizer.ask()) & {*first, *second}


def test_a_population_that_cannot_be_ranked_is_refused():
    with pytest.raises(ValidationError, match="population of 2 cannot be ranked"):
        CmaEs.Config(population=2)


def test_no_global_generator_is_touched():
    before = np.random.get_state()[1].copy()  # noqa: NPY002 - the one that must stay
    search(make(evaluations=60), smooth)
    np.testing.assert_array_equal(np.random.get_state()[1], before)  # noqa: NPY002


def test_a_state_of_other_settings_is_refused():
    optimizer = make(evaluations=100)
    optimizer.tell([Evaluated(candidate, smooth(candidate)) for candidate in optimizer.ask()])
    with pytest.raises(ValueError, match="other candidates than the run to resume"):
        make(evaluations=100, sigma=0.4).restore(optimizer.state())


variables = st.one_of(
    st.builds(
        lambda low, span: Continuous("a", low, low + span, "m"), st.floats(-1e3, 1e3), st.floats(1e-3, 1e3)
    ),
    st.builds(lambda low, span: Integer("a", low, low + span), st.integers(-50, 50), st.integers(1, 40)),
    st.builds(lambda count: Categorical("a", tuple(range(count))), st.integers(1, 9)),
)


@settings(max_examples=25, deadline=None)
@given(
    kinds=st.lists(variables, min_size=1, max_size=3),
    seed=st.integers(0, 2**32),
    fitness=st.lists(st.none() | st.floats(-1e6, 1e6), min_size=1, max_size=30),
    after=st.integers(0, 6),
)
def test_any_space_and_any_fitness_can_be_resumed_bit_by_bit(kinds, seed, fitness, after):
    from dataclasses import replace

    space = DesignSpace([replace(kind, name=f"v{i}") for i, kind in enumerate(kinds)])

    def results_of(optimizer):
        return [
            Evaluated(c, fitness[int(c.key, 16) % len(fitness)]) for c in optimizer.ask()
        ]  # depends on the candidate alone

    unbroken, resumed = make(space, seed, evaluations=40), make(space, 0, evaluations=40)
    for done in range(12):
        if done == after:
            resumed.restore(json.loads(json.dumps(unbroken.state(), allow_nan=False)))
        if done >= after:
            assert [c.genes for c in resumed.ask()] == [c.genes for c in unbroken.ask()]
            assert resumed.stop() == unbroken.stop()
        if unbroken.stop() is not None:
            return
        if done >= after:
            resumed.tell(results_of(resumed))
        unbroken.tell(results_of(unbroken))


def test_ipop_doubles_the_population():
    restarts = Restarts("ipop", 6, 0.2, np.random.default_rng(1))
    assert [restarts.next(100 * i).population for i in range(4)] == [6, 12, 24, 48]


def test_bipop_gives_both_regimes_a_like_share():
    restarts = Restarts("bipop", 6, 0.2, np.random.default_rng(1))
    spent = {"small": 0, "large": 0}
    evaluations = 12
    restarts.next(evaluations)
    kind = "large"
    for _ in range(40):
        cost = 50 if kind == "small" else 120
        spent[kind] += cost
        evaluations += cost
        descent = restarts.next(evaluations)
        kind = "large" if descent.sigma == 0.2 else "small"
        assert 0.002 <= descent.sigma <= 0.2
        assert descent.population >= 6
    assert abs(spent["small"] - spent["large"]) <= 120
