"""Optuna's samplers."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_framework.catalog import find_catalog
from tacos_framework.contracts import DesignProblem, Evaluated
from tacos_framework.errors import UserError
from tacos_framework.fitness import Fitness, FitnessTerm
from tacos_framework.variables.design_space import (
    CatalogChoice,
    Categorical,
    Continuous,
    DesignSpace,
    Integer,
)
from tacos_plugins.optimizers import optuna_search
from tacos_plugins.optimizers.optuna_search import OptunaSearch
from tacos_plugins.optimizers.random_search import RandomSearch
from tests.optimizers.landscapes import MIXED, mixed, regret, search

optuna = pytest.importorskip("optuna", reason="the extra optuna is not installed")


def make(space: DesignSpace = MIXED, seed: int = 1, problem=None, **config) -> OptunaSearch:
    rng = np.random.default_rng(seed)
    return OptunaSearch(OptunaSearch.Config(**config), space=space, rng=rng, problem=problem)


def fenced_problem(broken) -> DesignProblem:
    return DesignProblem(Fitness((FitnessTerm("task.score", 1.0),)), 1, coordinates=dict, broken=broken)


def draws(seed: int, evaluations: int) -> RandomSearch:
    return RandomSearch(
        RandomSearch.Config(evaluations=evaluations), space=MIXED, rng=np.random.default_rng(seed)
    )


def test_tpe_finds_an_optimum_in_120_evaluations_closer_than_random_search():
    found = regret(lambda seed: make(seed=seed, evaluations=120, batch=2), mixed, seeds=5)
    drawn = regret(lambda seed: draws(seed, 120), mixed, seeds=5)
    assert found < 0.1
    assert drawn > 0.15


def test_gp_finds_an_optimum_in_40_evaluations_where_random_search_does_not():
    pytest.importorskip("torch", reason="torch is not installed")
    found = regret(lambda seed: make(seed=seed, sampler="gp", evaluations=40, batch=4), mixed, seeds=3)
    drawn = regret(lambda seed: draws(seed, 40), mixed, seeds=3)
    assert found < 0.1
    assert drawn > 0.2


def test_gp_without_torch_says_what_to_install(monkeypatch):
    monkeypatch.setattr(optuna_search, "find_spec", lambda _: None)
    with pytest.raises(UserError, match="Install torch, or use sampler tpe"):
        make(sampler="gp")


def test_failures_are_avoided():
    """Half of the space fails; the model learns to stay out of it."""

    def fenced(candidate):
        return None if candidate.genes[1] < 50 else mixed(candidate)

    optimizer, late = make(evaluations=80), []
    while optimizer.stop() is None:
        observed = [Evaluated(candidate, fenced(candidate)) for candidate in optimizer.ask()]
        late = [*late, *(result.fitness is None for result in observed)][-30:]
        optimizer.tell(observed)
    assert np.mean(late) < 0.2


def beyond_the_fence(candidate):
    """Half of the space breaks a constraint, the optimum of `mixed` among it."""
    excess = candidate.genes[1] - 50
    return {"b_deg": excess} if excess > 0 else {}


@pytest.mark.parametrize("sampler", ["tpe", "gp"])
def test_what_is_known_to_break_a_constraint_is_not_asked(sampler):
    optimizer = make(sampler=sampler, evaluations=16, initial=6, problem=fenced_problem(beyond_the_fence))
    asked = []
    while optimizer.stop() is None:
        asked += optimizer.ask()
        optimizer.tell([Evaluated(candidate, mixed(candidate)) for candidate in optimizer.ask()])
    assert len(asked) == 16
    assert all(candidate.genes[1] <= 50 for candidate in asked)
    broken = [trial.constraints["broken"] for trial in optimizer._study.trials if trial.constraints]
    assert max(broken) > 0 == min(broken)  # the model has learnt of those as well


def test_where_nothing_can_be_built_it_asks_all_the_same():
    optimizer = make(evaluations=3, problem=fenced_problem(lambda _: {"b_deg": 1.0}))
    for _ in range(3):
        optimizer.tell([Evaluated(c, None, broken={"b_deg": 1.0}) for c in optimizer.ask()])
    assert optimizer.stop() is not None


def test_constraints_are_learnt_from_what_breaks_them():
    """Told of them only afterwards, it keeps to them better than draws do, though the optimum lies beyond."""
    late = []
    for seed in range(3):
        optimizer, broke = make(seed=seed, evaluations=60), []
        while optimizer.stop() is None:
            told = []
            for candidate in optimizer.ask():
                broken = beyond_the_fence(candidate)
                told.append(Evaluated(candidate, None if broken else mixed(candidate), broken=broken))
            broke += [bool(result.broken) for result in told]
            optimizer.tell(told)
        late += broke[-30:]
    assert np.mean(late) < 0.4


def test_the_model_learns_from_what_was_simulated():
    """Genes that snap to parts of a catalog are told as the parts have them, not as they were proposed."""
    catalog = find_catalog("image_sensors")
    space = DesignSpace([CatalogChoice("sensor", catalog), Continuous("pitch_deg", -30, 30, "deg")])
    optimizer = make(space, evaluations=12, batch=3)
    asked = []
    while optimizer.stop() is None:
        asked += optimizer.ask()
        optimizer.tell([Evaluated(c, -abs(c.values["pitch_deg"])) for c in optimizer.ask()])
    complete = optimizer._study.get_trials(states=[optuna.trial.TrialState.COMPLETE])
    names = [gene.name for gene in space.genes]
    assert [tuple(trial.params[name] for name in names) for trial in complete] == [c.genes for c in asked]


def test_its_logs_and_warnings_stay_out_of_a_study(capfd):
    optuna.logging.set_verbosity(optuna.logging.DEBUG)
    try:
        search(make(evaluations=15), mixed)
        assert optuna.logging.get_verbosity() == optuna.logging.DEBUG
    finally:
        optuna.logging.set_verbosity(optuna.logging.INFO)
    assert capfd.readouterr() == ("", "")


def test_values_without_order_are_told_as_such():
    space = DesignSpace([Categorical("lens", ("wide", "tele")), Integer("n", 1, 4)])
    kinds = {name: type(kind).__name__ for name, kind in make(space)._distributions.items()}
    assert kinds == {"lens": "CategoricalDistribution", "n": "IntDistribution"}


def test_a_product_that_leaves_nothing_free_is_searched_all_the_same():
    assert search(make(DesignSpace([]), evaluations=3), lambda _: 1.0) == 1.0


@settings(max_examples=8, deadline=None)
@given(
    seed=st.integers(0, 2**32),
    batch=st.integers(1, 4),
    fitness=st.lists(st.none() | st.floats(-1e6, 1e6), min_size=1, max_size=20),
    after=st.integers(0, 8),
    informed=st.booleans(),
)
def test_any_fitness_can_be_resumed_bit_by_bit(seed, batch, fitness, after, informed):
    space = DesignSpace([Continuous("a", 0, 1, "m"), Categorical("lens", ("wide", "normal", "tele"))])

    def broken(candidate):
        return {"a_m": candidate.values["a"] - 0.7} if candidate.values["a"] > 0.7 else {}

    def result_of(candidate):
        if beyond := broken(candidate):
            return Evaluated(candidate, None, broken=beyond)
        return Evaluated(candidate, fitness[int(candidate.key, 16) % len(fitness)])

    def results_of(optimizer):
        return [result_of(candidate) for candidate in optimizer.ask()]

    config = {"evaluations": 24, "batch": batch, "initial": 5}
    config["problem"] = fenced_problem(broken) if informed else None
    unbroken, resumed = make(space, seed, **config), make(space, 0, **config)
    for _ in range(after):
        if unbroken.stop() is None:
            unbroken.tell(results_of(unbroken))
    resumed.restore(json.loads(json.dumps(unbroken.state(), allow_nan=False)))
    while unbroken.stop() is None:
        assert [c.genes for c in resumed.ask()] == [c.genes for c in unbroken.ask()]
        resumed.tell(results_of(resumed))
        unbroken.tell(results_of(unbroken))
    assert resumed.stop() == unbroken.stop()
