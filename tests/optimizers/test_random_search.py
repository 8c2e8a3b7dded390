"""Random search."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_framework.contracts import Evaluated
from tacos_framework.variables.design_space import Categorical, Continuous, DesignSpace
from tacos_plugins.optimizers.random_search import RandomSearch

SPACE = DesignSpace([Continuous("x", 2, 4, "m"), Categorical("lens", ("wide", "tele"))])


def search(**config) -> RandomSearch:
    return RandomSearch(RandomSearch.Config(**config), space=SPACE, rng=np.random.default_rng(1))


def run(optimizer: RandomSearch) -> list[list]:
    batches = []
    while optimizer.stop() is None:
        batches.append(optimizer.ask())
        optimizer.tell([Evaluated(candidate, 0.0) for candidate in batches[-1]])
    return batches


def test_it_draws_as_many_as_it_is_told_the_last_batch_being_smaller():
    optimizer = search(evaluations=10, batch=4)
    assert [len(batch) for batch in run(optimizer)] == [4, 4, 2]
    assert optimizer.stop() == "all 10 candidates were evaluated"


def test_draws_are_uniform():
    drawn = [candidate for batch in run(search(evaluations=4000, batch=500)) for candidate in batch]
    x = np.array([candidate.values["x"] for candidate in drawn])
    assert x.mean() == pytest.approx(3, abs=0.05)
    assert x.std() == pytest.approx(2 / np.sqrt(12), rel=0.05)
    assert np.mean([candidate.values["lens"] == "wide" for candidate in drawn]) == pytest.approx(
        0.5, abs=0.04
    )


def test_what_candidates_score_changes_nothing():
    one, other = search(), search()
    for optimizer, fitness in ((one, 1.0), (other, None)):
        optimizer.tell([Evaluated(candidate, fitness) for candidate in optimizer.ask()])
    assert one.ask() == other.ask()
