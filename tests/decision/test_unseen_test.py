"""Scenes are added for those that are not decided, and for nobody else."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.fitness import Fitness, FitnessTerm
from tacos_framework.recipe import Test as Settings
from tacos_framework.simulation import ScoreJob, with_fitness
from tacos_framework.simulation.evaluation import Evaluation
from tacos_framework.study.unseen_test import UnseenTest, first_episodes

FITNESS = Fitness((FitnessTerm("task.score", 1.0),))
LEVELS = {"designed": 1.0, "far": 0.0, "near": 0.97, "twin": 1.0, "fickle": 0.5}
SPREADS = {"fickle": 3.0}


def _scores(job: ScoreJob) -> Evaluation:
    """Scenes differ much, cameras little; what a camera makes of a scene is its own."""
    name = job.values["name"]
    episodes = []
    for spec in job.episodes:
        scene = np.random.default_rng([spec.seed, spec.name[1]]).normal()
        own = np.random.default_rng([spec.seed, spec.name[1], len(name)]).normal()
        episodes.append({"task.score": LEVELS[name] + scene + SPREADS.get(name, 0.05) * own})
    if name == "broken":
        return Evaluation(job.values, failed="it broke")
    return Evaluation(job.values, episodes=tuple(episodes), images=len(episodes))


_scores.plan = SimpleNamespace(fitness=FITNESS)


class _Workers:
    def __init__(self, workers: int):
        self.workers = workers

    def map(self, evaluate, jobs):
        return [evaluate(job) for job in jobs]


def _test(
    workers: int = 1, cameras=("designed", "far", "near", "twin"), margin: float = 0.01, **settings
) -> UnseenTest:
    fitness = Fitness((FitnessTerm("task.score", 1.0, margin),))
    test = UnseenTest(Settings(seed=1, **{"episodes": 8, **settings}), fitness, "designed")
    jobs = {name: ScoreJob({"name": name}, ()) for name in cameras}
    test.run(jobs, _Workers(workers), _scores, lambda count: None, lambda evaluation: None)
    return test


def test_products_that_are_decided_see_no_further_scenes():
    test = _test(most_episodes=30, margin=0.0)
    found = test.comparisons
    assert found["far"].verdict == "better"
    assert found["far"].episodes == 8
    assert found["twin"].verdict == "undecided"
    assert found["twin"].episodes == len(test.evaluations["designed"].blocks) == 30
    assert found["far"].interval[0] < 1.0 < found["far"].interval[1]


def test_once_the_best_product_is_decided_the_others_see_no_further_scenes_either():
    test = _test(most_episodes=30, margin=0.1, cameras=("designed", "twin", "fickle"))
    found = test.comparisons
    assert found["fickle"].verdict == "undecided"
    assert found["twin"].verdict == "equivalent"
    assert found["twin"].episodes == found["fickle"].episodes < 30


def test_without_more_scenes_there_is_one_look():
    assert {len(found.blocks) for found in _test().evaluations.values()} == {8}


def test_a_margin_makes_equals():
    found = _test(most_episodes=60, margin=0.1).comparisons
    assert found["twin"].verdict == "equivalent"
    assert found["twin"].episodes < 60


@given(st.floats(-1e3, 1e3), st.sampled_from([0.0, 0.02, 0.1]))
def test_what_is_added_to_the_fitness_of_all_changes_no_verdict(constant, margin):
    """The zero of a fitness is arbitrary: a score less its mean is as good a score."""
    plain = _test(most_episodes=20, margin=margin)
    moved = replace(plain)
    moved.evaluations = {
        name: with_fitness(
            replace(
                found, episodes=tuple({"task.score": e["task.score"] + constant} for e in found.episodes)
            ),
            plain.fitness,
        )
        for name, found in plain.evaluations.items()
    }
    assert moved.comparisons.keys() == plain.comparisons.keys()
    for name, found in moved.comparisons.items():
        assert found.verdict == plain.comparisons[name].verdict
        assert found.margin == plain.comparisons[name].margin
        assert found.interval == pytest.approx(plain.comparisons[name].interval, abs=1e-9)


@pytest.mark.parametrize("workers", [2, 5])
def test_the_number_of_workers_changes_nothing(workers):
    one, several = _test(1, most_episodes=20), _test(workers, most_episodes=20)
    assert several.comparisons == one.comparisons
    assert several.evaluations == one.evaluations


def test_a_test_that_goes_on_ends_as_one_that_never_stopped():
    whole = _test(most_episodes=20)
    again = _test(most_episodes=20, cameras=())
    again.evaluations = {n: first_episodes(e, 8, FITNESS) for n, e in whole.evaluations.items()}
    jobs = {name: ScoreJob({"name": name}, ()) for name in whole.evaluations}
    again.run(jobs, _Workers(1), _scores, lambda count: None, lambda evaluation: None)
    assert again.comparisons == whole.comparisons


def test_scores_that_are_shown_side_by_side_are_of_the_same_scenes():
    test = _test(most_episodes=30, margin=0.0)
    common = test.on_common_scenes
    assert {len(found.blocks) for found in common.values()} == {8}
    expected = with_fitness(_scores(ScoreJob({"name": "twin"}, test.episodes(0, 8))), FITNESS)
    assert common["twin"].fitness == pytest.approx(expected.fitness)


def test_a_camera_that_fails_is_compared_with_nobody(monkeypatch):
    monkeypatch.setitem(LEVELS, "broken", 0.0)
    test = _test(cameras=("designed", "far", "broken"), most_episodes=12)
    assert set(test.comparisons) == {"far"}
    assert test.evaluations["broken"].failed == "it broke"
