"""Bayesian optimization along physical coordinates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.contracts import Asked, Evaluated
from tacos_plugins.optimizers.genetic import Genetic
from tacos_plugins.optimizers.physical_gp.episodes import next_episodes
from tacos_plugins.optimizers.physical_gp.optimizer import PhysicalGp
from tacos_plugins.optimizers.physical_gp.starts import spread_out
from tacos_plugins.optimizers.physical_gp.viability import Viability
from tacos_plugins.optimizers.random_search import RandomSearch
from tests.optimizers.camera_problem import FITNESS, CameraProblem
from tests.optimizers.landscapes import mixed, regret
from tests.optimizers.physical_gp_runs import candidates_of, finish, make


def test_with_200_images_it_finds_cameras_that_others_do_not_find_with_2000():
    """Ten seeds each, scenes and noise of their own; medians of the regret."""

    def median(make_optimizer, images):
        found = []
        for seed in range(10):
            camera = CameraProblem(seed)
            found.append(camera.search(make_optimizer(camera, np.random.default_rng(seed)), images))
        return np.median(found)

    ours = PhysicalGp.Config(evaluations=25)
    genetic = Genetic.Config()
    draws = RandomSearch.Config(evaluations=100)
    regret_of_ours = median(lambda c, rng: PhysicalGp(ours, space=c.space, rng=rng, problem=c.problem), 200)
    regret_of_genetic = median(lambda c, rng: Genetic(genetic, space=c.space, rng=rng), 2000)
    regret_of_draws = median(lambda c, rng: RandomSearch(draws, space=c.space, rng=rng), 2000)
    assert regret_of_ours < 0.1
    assert regret_of_ours < regret_of_genetic < regret_of_draws


def test_without_a_problem_it_searches_by_the_variables():
    assert regret(lambda seed: make(seed=seed, evaluations=40), mixed, seeds=3) < 0.15


def test_what_breaks_a_constraint_is_never_asked():
    camera = CameraProblem(1)
    optimizer = make(camera.space, problem=camera.problem, evaluations=14)
    for asked in finish(optimizer, camera.evaluate):
        assert not any(camera.broken(candidate) for candidate in candidates_of(asked))
    assert not any(camera.broken(candidate) for candidate in optimizer.recommend(5))


def test_candidates_take_turns_on_the_scenes_one_at_a_time():
    camera = CameraProblem(1, episodes=4)
    asked = [
        a
        for r in finish(make(camera.space, problem=camera.problem, evaluations=24), camera.evaluate)
        for a in r
    ]
    episodes = [each.episodes for each in asked]
    assert all(len(each) == 1 for each in episodes)
    assert np.bincount([number for (number,) in episodes]).tolist() == [6, 6, 6, 6]


@given(
    count=st.integers(1, 4),
    turn=st.integers(0, 30),
    episodes=st.integers(1, 6),
    done=st.sets(st.integers(0, 5), max_size=5),
)
def test_the_episodes_of_a_turn_are_new_to_the_candidate(count, turn, episodes, done):
    done = {number for number in done if number < episodes}
    chosen = next_episodes(count, turn, episodes, 7, done)
    assert len(set(chosen)) == len(chosen) == min(count, episodes - len(done))
    assert set(chosen) <= set(range(episodes)) - done


def test_as_many_episodes_as_there_are_is_all_of_them():
    camera = CameraProblem(1, episodes=2)
    optimizer = make(camera.space, problem=camera.problem, episodes_per_candidate=2)
    assert not any(isinstance(each, Asked) for each in optimizer.ask())


def test_recommended_cameras_differ_and_the_best_comes_first():
    camera = CameraProblem(1)
    optimizer = make(camera.space, problem=camera.problem, evaluations=30)
    finish(optimizer, camera.evaluate)
    found = optimizer.recommend(4)
    assert len(set(found)) == 4
    worth = [camera.worth(candidate) for candidate in found]
    assert worth[0] > 1.4
    assert max(worth) - worth[0] < 0.1
    assert optimizer.recommend(2) == found[:2]


def test_among_finalists_noise_does_not_choose_but_what_many_scenes_show_does():
    camera = CameraProblem(1)
    optimizer = make(camera.space, problem=camera.problem, evaluations=40)
    finish(optimizer, camera.evaluate)
    good = optimizer.recommend(1)[0]
    narrow = camera.space.decode([25.0, 20.0, *good.genes[2:]])  # sees no threshold
    asked = optimizer.state()
    assert camera.worth(narrow) < camera.worth(good) - 0.5
    once = [camera.evaluate(Asked(candidate, (0,))) for candidate in (narrow, good)]
    assert optimizer.choose(once) == 1
    lucky = replace(once[0], fitness=9.0)  # the scores themselves are what counts
    assert optimizer.choose([lucky, once[1]]) == 1
    assert optimizer.state() == asked


def test_a_score_that_no_scene_of_a_candidate_had_is_no_failure():
    """With one scene a candidate, none may have a threshold; the features of its images still teach."""
    camera = CameraProblem(1)

    def evaluate(asked):
        result = camera.evaluate(asked)
        if asked.episodes != (0,):
            return result
        features = {0: {k: v for k, v in result.episodes[0].items() if k != "door.seen"}}
        return replace(
            result, fitness=None, failed="no episode gave a value for door.seen", episodes=features
        )

    optimizer = make(camera.space, problem=camera.problem, evaluations=24)
    finish(optimizer, evaluate)
    assert camera.worth(optimizer.recommend(1)[0]) > 1.2


def test_tasks_that_learn_meanwhile_do_not_mislead_it():
    """All scores grow by as much as cameras differ; later cameras are not better for it."""
    camera = CameraProblem(1)
    camera.problem = replace(camera.problem, weights_learn=True, episodes_renew=True)
    images = 0

    def evaluate(asked):
        nonlocal images
        images += 1
        scores = {
            number: {**s, "orb.inliers": s["orb.inliers"] + 4 * images}
            for number, s in camera.evaluate(asked).episodes.items()
        }
        return Evaluated(asked.candidate, FITNESS.value(next(iter(scores.values()))), episodes=scores)

    optimizer = make(camera.space, problem=camera.problem, evaluations=30)
    finish(optimizer, evaluate)
    assert camera.worth(optimizer.recommend(1)[0]) > 1.2


def test_failures_are_avoided_and_never_asked_again():
    """Half of the space fails; the model learns to stay out of it."""

    def fenced(candidate):
        return (
            Evaluated(candidate, None, "no")
            if candidate.genes[1] < 50
            else Evaluated(candidate, mixed(candidate))
        )

    asked = [c for r in finish(make(evaluations=50), fenced) for c in r]
    assert len(set(asked)) == len(asked)
    assert np.mean([candidate.genes[1] < 50 for candidate in asked[-20:]]) < 0.4


def test_the_border_of_what_fails_is_found_along_the_coordinate_that_it_depends_on():
    rng = np.random.default_rng(1)
    rows = rng.random((40, 3))
    viability = Viability.fit(rows, rows[:, 1] > 0.4)
    new = rng.random((500, 3))
    assert np.mean((viability.chances(new) > 0.5) == (new[:, 1] > 0.4)) > 0.9
    assert Viability.fit(rows, np.ones(40, dtype=bool)).chances(new).tolist() == [1.0] * 500


@pytest.mark.parametrize("value", [None, 0.0, 2.5])
def test_where_all_fail_or_are_equal_it_goes_on_looking_elsewhere(value):
    optimizer = make(evaluations=14, starts=4)
    history = finish(optimizer, lambda c: Evaluated(c, value, None if value is not None else "no"))
    asked = [candidate for each in history for candidate in each]
    assert len(set(asked)) == 14
    assert np.ptp([candidate.genes[1] for candidate in asked]) > 50
    assert len(optimizer.recommend(3)) == (0 if value is None else 3)


def test_it_stops_early_once_little_is_to_be_gained():
    def simple(c):
        return Evaluated(c, 10 - (c.genes[1] - 70) ** 2 / 1000)

    optimizer = make(evaluations=200, until_gain_below=0.01)
    history = finish(optimizer, simple)
    assert sum(map(len, history)) < 60
    assert optimizer.stop() == "no candidate is expected to gain 1 % of the fitness, for 3 rounds now"
    assert simple(optimizer.recommend(1)[0]).fitness > 9.9


def test_the_first_round_is_spread_over_what_tells_candidates_apart():
    rng = np.random.default_rng(1)
    free = rng.random(400)
    rows = np.column_stack([free, 2 * free + 1e-3 * rng.random(400), rng.random(400) ** 4, np.full(400, 0.5)])
    chosen = rows[spread_out(rows, 8, rng)]
    for column in (0, 2):
        eighths = np.searchsorted(np.quantile(rows[:, column], np.arange(1, 8) / 8), chosen[:, column])
        assert len(set(eighths)) >= 7, "a Latin hypercube over the ranks"


def test_of_fewer_candidates_than_starts_each_is_taken_once():
    assert sorted(spread_out(np.array([[0.1], [0.2]]), 8, np.random.default_rng(1))) == [0, 1]
