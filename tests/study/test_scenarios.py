"""Several scenarios in one study: every candidate is scored in each, and their mean or the worst counts."""

from __future__ import annotations

import json

import pytest
from toy_study import LEARNER, comparable, merged, run, toy_recipe

from tacos_framework.errors import CandidateFailed
from tacos_framework.fitness import Fitness, FitnessTerm
from tacos_framework.simulation import (
    EpisodeSpec,
    Evaluation,
    Evaluator,
    ScoreJob,
    merged_evaluation,
    with_fitness,
)
from tacos_framework.study.fitness_contributions import contributions

DAY, NIGHT = {"name": "day", "weight": 1}, {"name": "night", "weight": 3, "illumination_lux": 2}
BOTH = {"scenario": [DAY, NIGHT], "fitness": [{"score": "width.brightness", "weight": 2}]}
VALUES = {"focal_length_mm": 1.0, "pitch_deg": 0.0}
FITNESS = {
    over: Fitness((FitnessTerm("a", 2.0),), (("day", 1.0), ("night", 3.0)), over)
    for over in ("mean", "worst")
}


def scored(toys, recipe):
    return Evaluator(recipe, toys)(ScoreJob(VALUES, (EpisodeSpec(3, ("design", 0, 0)),)))


def alone(scenario):
    return {key: value for key, value in scenario.items() if key not in ("name", "weight")}


def test_each_scenario_scores_what_it_scores_by_itself_on_the_same_world(toys):
    both = scored(toys, toy_recipe(**BOTH))
    for scenario in (DAY, NIGHT):
        single = scored(toys, toy_recipe(**{**BOTH, "scenario": alone(scenario)}))
        assert both.scenarios[scenario["name"]] == {**single.scores, "fitness": single.fitness}
        assert single.scenarios == {}
    assert both.scenarios["night"]["width.brightness"] < both.scenarios["day"]["width.brightness"] / 5


def test_the_weighted_mean_counts_or_the_worst(toys):
    mean = scored(toys, toy_recipe(**BOTH))
    by_scenario = [mean.scenarios[name]["fitness"] for name in ("day", "night")]
    assert mean.fitness == pytest.approx((by_scenario[0] + 3 * by_scenario[1]) / 4)
    assert mean.scores["width.brightness"] == pytest.approx(mean.fitness / 2)
    assert sum(mean.terms.values()) == pytest.approx(mean.fitness)
    assert mean.images == 2 * 6
    worst = scored(toys, toy_recipe(**BOTH, study={"scenarios": "worst"}))
    assert worst.fitness == pytest.approx(min(by_scenario))
    assert sum(worst.terms.values()) == pytest.approx(worst.fitness)
    assert worst.scores == mean.scores
    assert worst.scenarios == mean.scenarios


def test_one_scenario_in_a_list_is_the_scenario(toys, tmp_path):
    one = run(toy_recipe(scenario=alone(NIGHT)), toys, tmp_path / "one")
    listed = run(toy_recipe(scenario=[NIGHT]), toys, tmp_path / "listed")
    camera = listed["cameras"]["designed"]
    assert camera.pop("scenarios")["night"]["fitness"] == listed["test"]["designed"]["fitness"]
    listed["best"].pop("scenarios")
    for mine, alike in zip(camera.pop("finalists"), one["cameras"]["designed"].pop("finalists"), strict=True):
        assert mine["fitness"] == alike["fitness"]
        assert list(mine["episodes"]["0"]) == [f"night/{score}" for score in alike["episodes"]["0"]]
    assert listed.pop("conditions").replace("night: ", "") == one.pop("conditions")
    assert comparable(listed) == comparable(one)


@pytest.mark.parametrize("over", ["mean", "worst"])
def test_results_have_the_scenarios_beside(toys, tmp_path, over):
    recipe = toy_recipe(**BOTH, study={"scenarios": over}, optimizer={"generations": 2})
    result = run(recipe, toys, tmp_path / "out")
    assert set(result["best"]["scenarios"]) == {"day", "night"}
    tested = result["cameras"]["designed"]["scenarios"]
    fitness = [tested[name]["fitness"] for name in ("day", "night")]
    expected = min(fitness) if over == "worst" else (fitness[0] + 3 * fitness[1]) / 4
    assert result["test"]["designed"]["fitness"] == pytest.approx(expected)
    assert len(result["cameras"]["designed"]["episodes"]) == 2
    episodes = [episode["fitness"] for episode in result["cameras"]["designed"]["episodes"]]
    assert sum(episodes) / 2 == pytest.approx(expected)  # so that their spread is that of the fitness
    line = json.loads((tmp_path / "out" / "generations.jsonl").read_text().splitlines()[0])
    candidate = line["candidates"][0]
    assert candidate["scenarios"]["day"]["width.brightness"] > candidate["scenarios"]["night"]["fitness"] / 2


VARIANTS = {
    "blocks": {"study": {"episodes": 2, "blocks": 3}, "optimizer": {"population": 10}},
    "worst of blocks": {"study": {"blocks": 6, "scenarios": "worst"}},
    "shared weights": merged(LEARNER, {"study": {"train_best": 1}}),
    "branched weights": merged(
        LEARNER, {"nodes": {"learner": {"train": {"weights": "branched", "epochs": 2}}}}
    ),
    "compared": {"compare": {"cameras": ["flea3"], "evaluations": 3}, "rig": {"binning": 200}},
}


@pytest.mark.parametrize("variant", VARIANTS)
def test_workers_change_nothing_in_any_kind_of_study(toys, tmp_path, variant):
    sections = merged({"scenario": [DAY, NIGHT], "optimizer": {"generations": 2}}, VARIANTS[variant])
    local = run(toy_recipe(**sections), toys, tmp_path / "local")
    assert local["test"]["designed"]["fitness"] is not None
    spread = toy_recipe(**sections, executor={"use": "executor.process", "workers": 2})
    assert comparable(run(spread, toys, tmp_path / "two")) == comparable(local)


def test_a_broken_run_resumes_to_the_same_result(toys, tmp_path, monkeypatch):
    from toy_plugin import WidthTask

    recipe = toy_recipe(scenario=[DAY, NIGHT], study={"renew_episodes": "never"})
    whole = run(recipe, toys, tmp_path / "whole")
    monkeypatch.setattr(WidthTask, "begun", 0)
    monkeypatch.setattr(WidthTask, "interrupt_at", 17)
    assert run(recipe, toys, tmp_path / "broken")["stopped"] == "interrupted by the user"
    monkeypatch.setattr(WidthTask, "interrupt_at", None)
    resumed = run(recipe, toys, tmp_path / "broken", resume=True)
    assert comparable(resumed) == comparable(whole)


def test_what_learns_sees_the_scenarios_in_turn(toys, monkeypatch):
    from toy_plugin import Learner

    seen = []
    fit = Learner.fit

    def watched(self, batches, **supplied):
        listed = list(batches)
        seen.extend(float(batch.images[0].mean()) for batch in listed)
        return fit(self, listed, **supplied)

    monkeypatch.setattr(Learner, "fit", watched)
    evaluate = Evaluator(toy_recipe(**merged(LEARNER, {"scenario": [DAY, NIGHT]})), toys)
    states = evaluate.simulation.initial_states()
    spec = EpisodeSpec(3, ("train", 0, 0))
    evaluation = evaluate(ScoreJob(VALUES, (), states, training=spec, partial=True))
    assert len(seen) == 2 * 6
    assert evaluation.images == 2 * 6
    assert min(seen[0::2]) > 5 * max(seen[1::2])  # day, night, day, night
    seen.clear()
    named = EpisodeSpec(3, ("train", 0, 0), scenario="night")
    evaluate(ScoreJob(VALUES, (), states, training=named, partial=True))
    assert len(seen) == 6


def evaluation(*rows):
    """Episodes of two scenarios, each row one world: score of day, score of night."""
    columns = {"day": [row[0] for row in rows], "night": [row[1] for row in rows]}
    return Evaluation(
        values={},
        scenario_episodes={
            name: tuple({} if value is None else {"a": value} for value in column)
            for name, column in columns.items()
        },
    )


def test_worlds_that_were_scored_in_parts_are_judged_together():
    parts = [evaluation((1.0, 5.0)), evaluation((3.0, 1.0), (2.0, 0.0))]
    whole = merged_evaluation(parts, FITNESS["mean"])
    assert whole == with_fitness(evaluation((1.0, 5.0), (3.0, 1.0), (2.0, 0.0)), FITNESS["mean"])
    assert whole.scenarios == {"day": {"a": 2.0, "fitness": 4.0}, "night": {"a": 2.0, "fitness": 4.0}}
    assert whole.episodes[0] == {"a": 4.0, "fitness": 8.0}


def test_a_scenario_without_a_score_fails_the_candidate_and_is_named():
    with pytest.raises(CandidateFailed, match="in scenario 'night': no episode gave a value for a"):
        with_fitness(evaluation((1.0, None), (2.0, None)), FITNESS["mean"])
    partly = with_fitness(evaluation((1.0, None), (2.0, 3.0)), FITNESS["mean"])
    assert partly.fitness == pytest.approx(2 * (1.5 + 3 * 3.0) / 4)
    assert "fitness" not in partly.episodes[0]


@pytest.mark.parametrize("over", ["mean", "worst"])
def test_what_a_world_contributes_has_the_mean_and_the_spread_of_the_fitness(over):
    rows = [(1.0, 0.5), (3.0, 0.1), (2.0, 0.9)]
    found = with_fitness(evaluation(*rows), FITNESS[over])
    told = contributions(found.blocks, FITNESS[over])
    assert told.mean() == pytest.approx(found.fitness)
    assert told.tolist() == pytest.approx([episode["fitness"] for episode in found.episodes])
    assert contributions(evaluation((1.0, None), (2.0, 1.0)).blocks, FITNESS[over]) is None
