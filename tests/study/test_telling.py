"""What a study tells its optimizer, what it charges for, and which camera it takes in the end."""

from __future__ import annotations

import json
import math
import sys
from typing import ClassVar

import numpy as np
import pytest
import toy_plugin
from toy_study import comparable, run, toy_recipe

from tacos_framework.components import Component
from tacos_framework.contracts import Asked
from tacos_framework.hookspecs import hookimpl
from tacos_framework.plan import make_plan
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Recipe
from tacos_framework.settings import Settings, setting
from tacos_framework.simulation import Evaluator
from tacos_framework.study import search as searching
from tacos_framework.study.search import Search

FEASIBLE = {"hfov_deg": {"max": 40}}
"""About half of the design space."""


class Rotating:
    """Draws at random, has each candidate scored on a few episodes in turn, and recommends the narrowest."""

    class Config(Settings):
        rounds: int = setting(4, help="Rounds of two candidates.")
        at_a_time: int = setting(1, help="Episodes of a candidate; 0 for all.")

    told: ClassVar[list] = []
    problems: ClassVar[list] = []

    def __init__(self, config, *, space, rng, problem):
        self.config, self._space, self._rng, self._problem = config, space, rng, problem
        self._done, self._seen = 0, []
        Rotating.problems.append(problem)

    expected_candidates = None

    def ask(self):
        rng = np.random.default_rng(self._done)
        candidates = [self._space.sample(rng) for _ in range(2)]
        if not self.config.at_a_time:
            return candidates
        first = self._done * self.config.at_a_time
        chosen = {(first + i) % self._problem.episodes for i in range(self.config.at_a_time)}
        return [Asked(candidate, tuple(chosen)) for candidate in candidates]

    def tell(self, evaluated):
        Rotating.told.extend(evaluated)
        self._seen.extend(list(e.candidate.genes) for e in evaluated)
        self._done += 1

    def recommend(self, count):
        return [self._space.decode(genes) for genes in sorted(self._seen)[-count:]]

    def stop(self):
        return "all rounds are over" if self._done >= self.config.rounds else None

    def state(self):
        return {"done": self._done, "seen": self._seen}

    def restore(self, state):
        self._done, self._seen = state["done"], state["seen"]


@hookimpl
def tacos_components():
    return [Component("optimizer", "rotating", f"{__name__}:Rotating", summary="A toy.")]


@pytest.fixture(scope="module")
def plugins():
    found = Plugins.discover()
    found.register(toy_plugin)
    found.register(sys.modules[__name__])
    return found


@pytest.fixture(autouse=True)
def _fresh():
    Rotating.told, Rotating.problems = [], []


def recipe_of(optimizer, **sections):
    data = toy_recipe(**{"study": {"renew_episodes": "never", "episodes": 3}, **sections}).as_data()
    return Recipe.model_validate({**data, "optimizer": {"use": "optimizer.rotating", **optimizer}})


def lines_of(folder):
    return [json.loads(line) for line in (folder / "generations.jsonl").read_text().splitlines()]


def test_a_candidate_is_rendered_for_the_episodes_it_was_asked_on_and_no_others(plugins, tmp_path):
    result = run(recipe_of({}), plugins, tmp_path / "out")
    for i, line in enumerate(lines_of(tmp_path / "out")):
        for candidate in line["candidates"]:
            assert list(candidate["episodes"]) == [str(i % 3)]
            assert candidate["images"] == 6
    assert [list(e.episodes) for e in Rotating.told] == [[0]] * 2 + [[1]] * 2 + [[2]] * 2 + [[0]] * 2
    assert {e.images for e in Rotating.told} == {6}
    assert all(
        set(scores) == {"width.closeness", "width.brightness"}
        for e in Rotating.told
        for scores in e.episodes.values()
    )
    designed, finalists, tested = 8 * 6, 3 * 3 * 6, 2 * 4
    assert result["frames_rendered"] == designed + finalists + tested


def test_the_best_is_the_best_recommended_on_fresh_episodes(plugins, tmp_path):
    result = run(recipe_of({}, study={"finalists": 2, "final_episodes": 5}), plugins, tmp_path / "out")
    finalists = result["cameras"]["designed"]["finalists"]
    narrowest = sorted(e.candidate.genes for e in Rotating.told)[-2:]
    assert [finalist["camera"]["focal_length_mm"] for finalist in finalists] == [g[0] for g in narrowest]
    assert [list(finalist["episodes"]) for finalist in finalists] == [list("01234")] * 2
    assert result["best"]["fitness"] == max(finalist["fitness"] for finalist in finalists)


def test_a_lone_finalist_is_scored_by_the_test_alone(plugins, tmp_path):
    result = run(recipe_of({}, study={"finalists": 1}), plugins, tmp_path / "out")
    designed = result["cameras"]["designed"]
    assert designed["finalists"] == []
    assert designed["camera"]["focal_length_mm"] == max(e.candidate.genes for e in Rotating.told)[0]
    assert result["frames_rendered"] == 8 * 6 + 2 * 4  # the search and the test
    assert result["best"]["camera"] == designed["camera"]
    assert {**result["best"]["scores"], "fitness": result["best"]["fitness"]} == result["test"]["designed"]
    assert result["best"]["derived"]["hfov_deg"] == designed["derived"]["hfov_deg"] > 0


@pytest.mark.parametrize("unfit", ["untested", "infeasible"])
def test_a_lone_finalist_is_scored_first_where_no_test_can_tell(plugins, tmp_path, monkeypatch, unfit):
    sections = {"test": None} if unfit == "untested" else {"constraints": FEASIBLE}
    if unfit == "infeasible":
        monkeypatch.setattr(Rotating, "recommend", lambda self, count: [self._space.decode([1.0, 0.0])])
    result = run(recipe_of({}, study={"finalists": 1}, **sections), plugins, tmp_path / "out")
    (finalist,) = result["cameras"]["designed"]["finalists"]
    assert bool(finalist["broken"]) == (unfit == "infeasible")
    assert (result["best"]["fitness"] == finalist["fitness"]) == (unfit == "untested")
    assert result["best"]["fitness"] is not None


def test_an_optimizer_may_choose_among_the_finalists_by_what_they_scored(plugins, tmp_path, monkeypatch):
    def worst(self, finalists):
        assert all(list(finalist.episodes) == [0, 1] for finalist in finalists)
        return min(range(len(finalists)), key=lambda i: finalists[i].fitness)

    monkeypatch.setattr(Rotating, "choose", worst, raising=False)
    result = run(recipe_of({}, study={"final_episodes": 2}), plugins, tmp_path / "out")
    finalists = result["cameras"]["designed"]["finalists"]
    assert result["best"]["fitness"] == min(finalist["fitness"] for finalist in finalists)
    assert result["best"]["fitness"] < max(finalist["fitness"] for finalist in finalists)


def test_scores_are_told_with_the_errors_of_their_means(plugins, tmp_path):
    run(recipe_of({"at_a_time": 0}), plugins, tmp_path / "out")
    for told in Rotating.told:
        closeness = [scores["width.closeness"] for scores in told.episodes.values()]
        assert len(closeness) == 3
        assert told.fitness == pytest.approx(np.mean(closeness))
        expected = np.std(closeness, ddof=1) / math.sqrt(3)
        assert told.standard_errors["width.closeness"] == pytest.approx(expected)


@pytest.mark.parametrize("begun", [5, 8 + 3, 8 + 3 * 3 + 1], ids=["search", "finalists", "test"])
def test_a_break_does_not_change_it(plugins, tmp_path, monkeypatch, begun):
    whole = run(recipe_of({}), plugins, tmp_path / "whole")
    monkeypatch.setattr(toy_plugin.WidthTask, "begun", 0)
    monkeypatch.setattr(toy_plugin.WidthTask, "interrupt_at", begun)
    assert run(recipe_of({}), plugins, tmp_path / "broken")["stopped"] == "interrupted by the user"
    assert comparable(run(recipe_of({}), plugins, tmp_path / "broken", resume=True)) == comparable(whole)


def test_what_breaks_a_constraint_costs_nothing_and_is_no_evaluation(plugins, tmp_path):
    result = run(recipe_of({"rounds": 10}, constraints=FEASIBLE), plugins, tmp_path / "out")
    broken = [told for told in Rotating.told if told.broken]
    assert broken
    for told in broken:
        assert told.fitness is None
        assert told.images == 0
        assert told.broken == Rotating.problems[0].broken(told.candidate)
        assert told.failed.startswith("hfov_deg is ")
    assert result["cameras"]["designed"]["evaluations"] == 20 - len(broken)


class Here:
    """An executor that does as it is told."""

    def map(self, evaluate, jobs):
        return [evaluate(job) for job in jobs]


def test_a_budget_is_spent_on_what_can_be_built(plugins):
    plan = make_plan(recipe_of({"rounds": 40}, constraints=FEASIBLE), plugins)
    search, evaluate = Search("designed", plan, plan.space, {}, budget=6), Evaluator(plan, plugins)
    while not search.stopped:
        search.step(Here(), evaluate, lambda _: None)
    assert search.stopped == f"{search.evaluations} evaluations, the budget of 6, are spent"
    assert search.n_observed > search.evaluations
    restored = Search("designed", plan, plan.space, {}, budget=6)
    restored.restore(json.loads(json.dumps(search.state())), {})
    assert json.loads(json.dumps(restored.state())) == json.loads(json.dumps(search.state()))


def test_a_search_in_which_nothing_can_be_built_ends_and_names_the_constraint(plugins, tmp_path, monkeypatch):
    monkeypatch.setattr(searching, "MOST_BROKEN_IN_A_ROW", 10)
    recipe = recipe_of(
        {"rounds": 1000}, constraints={"vfov_deg": {"max": 9.2}}
    )  # one corner of the space keeps it
    result = run(recipe, plugins, tmp_path / "out")
    assert result["best"] is None
    assert result["stopped"].startswith("10 candidates in a row broke a constraint, the last as vfov_deg is ")
    assert result["stopped"].endswith("above the largest allowed value 9.2")
    assert (result["evaluations"], result["frames_rendered"]) == (0, 0)


def test_an_episode_without_meaning_is_told_with_what_it_has(plugins, tmp_path, monkeypatch):
    """A scene may hold nothing that a score is about; the candidate is not to blame."""
    sound = toy_plugin.WidthScorer.scores

    def scores(self):
        reported = sound(self)
        return {"brightness": reported["brightness"]} if reported["brightness"] < 130 else reported

    monkeypatch.setattr(toy_plugin.WidthScorer, "scores", scores)
    run(recipe_of({}), plugins, tmp_path / "out")
    without = [told for told in Rotating.told if told.fitness is None]
    assert without
    for told in without:
        ((_, reported),) = told.episodes.items()
        assert set(reported) == {"width.brightness"}
        assert "width.closeness" in told.failed
        assert told.images == 6
