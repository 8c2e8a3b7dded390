"""A whole study, of toys: what comes out, what is kept, what is repeatable."""

from __future__ import annotations

import json
import math

import pytest
import toy_plugin
from toy_study import LEARNER, comparable, run, toy_recipe

import tacos_framework
from tacos_framework.plugins import Plugins
from tacos_framework.simulation import EpisodeSpec, Evaluator, ScoreJob


def test_study_finds_the_best_width_and_says_so(toys, tmp_path):
    recipe = toy_recipe(study={"renew_episodes": "never"}, optimizer={"generations": 12})
    result = run(recipe, toys, tmp_path / "out")
    assert abs(result["best"]["derived"]["hfov_deg"] - 90) < 5
    assert set(result["test"]["designed"]) == {"width.closeness", "width.brightness", "fitness"}
    assert result["test"]["designed"]["fitness"] == result["test"]["designed"]["width.closeness"]
    assert result["stopped"]
    assert set(result["exposed"]) == set(result["samples"])
    assert all(0 <= share <= 1 for shares in result["exposed"].values() for share in shares.values())
    written = json.loads((tmp_path / "out" / "result.json").read_text())
    assert written == json.loads(json.dumps(result))
    lines = (tmp_path / "out" / "generations.jsonl").read_text().splitlines()
    assert len(lines) == 12
    found = {c["key"]: c["fitness"] for line in lines for c in json.loads(line)["candidates"]}
    finalists = result["cameras"]["designed"]["finalists"]
    assert {f["key"] for f in finalists} == set(sorted(found, key=found.get)[-3:])  # of all generations
    assert result["best"]["fitness"] == max(finalist["fitness"] for finalist in finalists)


def test_equal_seed_equal_result_and_another_seed_another(toys, tmp_path):
    first = run(toy_recipe(), toys, tmp_path / "a")
    assert comparable(run(toy_recipe(), toys, tmp_path / "b")) == comparable(first)
    assert comparable(run(toy_recipe(seed=4), toys, tmp_path / "c")) != comparable(first)


def test_workers_do_not_change_the_result(toys, tmp_path):
    local = run(toy_recipe(**LEARNER), toys, tmp_path / "local")
    spread = {"executor": {"use": "executor.process", "workers": 2}, **LEARNER}
    assert comparable(run(toy_recipe(**spread), toys, tmp_path / "two")) == comparable(local)


@pytest.mark.parametrize("renew", ["never", "each_generation"])
def test_elites_are_scored_again_only_where_that_tells_something_new(toys, tmp_path, renew):
    result = run(toy_recipe(study={"renew_episodes": renew}), toys, tmp_path / "out")
    lines = [json.loads(line) for line in (tmp_path / "out" / "generations.jsonl").read_text().splitlines()]
    cached = sum(candidate["cached"] for line in lines for candidate in line["candidates"])
    assert (cached >= 2 * 3) if renew == "never" else (cached == 0)
    finalists, tested = 3, 1
    assert result["evaluations"] == 6 * 4 - cached + finalists + tested


def test_candidates_of_a_generation_see_the_same_frames(toys, tmp_path):
    """With common random numbers two equal cameras at different pitch get equal frames, else not."""
    for common in (True, False):
        recipe = toy_recipe(study={"common_random_numbers": common})
        evaluate = Evaluator(recipe, toys)
        episodes = (EpisodeSpec(3, ("design", 0, 0)),)
        a, b = (
            evaluate(ScoreJob({"focal_length_mm": 1.0, "pitch_deg": pitch}, episodes)) for pitch in (0.0, 9.0)
        )
        assert (a.scores == b.scores) is common


class Remembering:
    """An executor that keeps the scores of each episode that a job was about."""

    def __init__(self):
        self.scored = []

    def map(self, evaluate, jobs):
        for job in jobs:
            outcome = evaluate(job)
            if isinstance(job.value, ScoreJob):
                self.scored += zip(job.value.episodes, outcome.value.episodes, strict=True)
            yield outcome


def test_a_camera_is_judged_on_as_many_different_worlds_as_were_asked_for(toys, tmp_path):
    executor = Remembering()
    # Without noise only the light of a world is left to tell frames of one camera apart.
    recipe = toy_recipe(test={"seed": 1001, "episodes": 5}, nodes={"frames": {"sigma_dn": 0.0}})
    result = run(recipe, toys, tmp_path / "out", executor=executor)
    brightness = [scores["width.brightness"] for spec, scores in executor.scored if spec.seed == 1001]
    assert len(brightness) == len(set(brightness)) == 5
    assert result["test"]["designed"]["width.brightness"] == pytest.approx(sum(brightness) / 5)


def test_off_the_shelf_cameras_are_fitted_and_tested_beside(toys, tmp_path):
    recipe = toy_recipe(
        compare={"cameras": ["flea3", "oak_d_pro_wide"], "evaluations": 7},
        rig={"binning": 200},
    )
    result = run(recipe, toys, tmp_path / "out")
    assert set(result["test"]) == {"designed", "flea3", "oak_d_pro_wide"}
    flea3 = result["cameras"]["flea3"]
    assert flea3["free"] == ["pitch_deg"]
    assert flea3["camera"]["focal_length_mm"] == 3.6
    assert flea3["derived"]["hfov_deg"] == pytest.approx(2 * math.degrees(math.atan(6.2 / 2 / 3.6)))
    assert flea3["evaluations"] >= 7


class Batches:
    """An executor that keeps what episodes the jobs of each batch were scored on."""

    def __init__(self):
        self.purposes = []

    def map(self, evaluate, jobs):
        scored = [job.value for job in jobs if isinstance(job.value, ScoreJob)]
        self.purposes.append([spec.name[0] for job in scored for spec in job.episodes[:1]])
        return map(evaluate, jobs)


def test_finalists_of_all_cameras_are_scored_in_one_batch(toys, tmp_path):
    executor = Batches()
    recipe = toy_recipe(
        compare={"cameras": ["flea3"], "evaluations": 7},
        rig={"binning": 200},
        study={"finalists": 2, "final_episodes": 1, "renew_episodes": "each_generation"},
    )
    result = run(recipe, toys, tmp_path / "out", executor=executor)
    finalists = [camera["finalists"] for camera in result["cameras"].values()]
    assert [len(each) for each in finalists] == [2, 2]
    assert [batch for batch in executor.purposes if "final" in batch] == [["final"] * 4]


@pytest.mark.parametrize(("weights", "evaluations"), [("shared", 5), ("branched", 5), ("frozen", 1)])
def test_tasks_learn_from_a_camera_that_leaves_nothing_free_as_long_as_from_others(
    toys, tmp_path, weights, evaluations
):
    learner = {**LEARNER["nodes"]["learner"], "train": {"weights": weights}}
    recipe = toy_recipe(
        nodes={"learner": learner},
        compare={"cameras": ["flea3"], "evaluations": 5},
        rig={"binning": 200},
        optimizer={"generations": 2},
    )
    recipe = recipe.model_copy(update={"design": {"focal_length_mm": recipe.design["focal_length_mm"]}})
    result = run(recipe, toys, tmp_path / "out")
    assert result["cameras"]["flea3"]["free"] == []
    assert result["cameras"]["flea3"]["evaluations"] == evaluations
    assert result["test"]["flea3"]["fitness"] is not None


def test_failed_candidates_are_told_and_the_study_goes_on(toys, tmp_path):
    reasons = []

    class Listener:
        @tacos_framework.hookimpl
        def tacos_candidate_failed(self, candidate, reason):
            reasons.append(reason)

    plugins = Plugins.discover()
    plugins.register(toy_plugin)
    plugins.register(Listener(), "listener")
    recipe = toy_recipe(nodes={"width": {"fail_above_deg": 60}}, constraints={"vfov_deg": {"min": 10}})
    result = run(recipe, plugins, tmp_path / "out")
    assert result["best"]["derived"]["hfov_deg"] <= 60
    assert any(reason.startswith("cannot judge") for reason in reasons)
    lines = [json.loads(line) for line in (tmp_path / "out" / "generations.jsonl").read_text().splitlines()]
    failed = [c for line in lines for c in line["candidates"] if c["failed"]]
    assert failed
    assert all(c["fitness"] is None for c in failed)


def test_a_candidate_that_takes_its_worker_along_is_told_as_failed(toys, tmp_path):
    deadly = {"nodes": {"width": {"die_above_deg": 100}}}
    failing = {"nodes": {"width": {"fail_above_deg": 100}}}
    observed = []
    for name, changes in (("deadly", deadly), ("failing", failing)):
        recipe = toy_recipe(executor={"use": "executor.process", "workers": 2}, **changes)
        result = run(recipe, toys, tmp_path / name)
        assert result["best"]["derived"]["hfov_deg"] <= 100
        lines = (tmp_path / name / "generations.jsonl").read_text().splitlines()
        observed.append([c for line in lines for c in json.loads(line)["candidates"]])
    reasons = {candidate.pop("failed") for candidate in observed[0]}
    assert reasons == {None, "its worker process was ended by SIGSEGV, 2 times in a row"}
    for candidate in observed[1]:
        del candidate["failed"]
    seen = ("camera", "fitness", "scores", "cached")
    assert [[c[k] for k in seen] for c in observed[0]] == [[c[k] for k in seen] for c in observed[1]]
    assert "SIGSEGV; it is tried again" in (tmp_path / "deadly" / "log.txt").read_text()


def test_what_breaks_a_constraint_is_not_simulated(toys):
    evaluate = Evaluator(toy_recipe(constraints={"hfov_deg": {"max": 60}}), toys)
    wide = evaluate(ScoreJob({"focal_length_mm": 0.5, "pitch_deg": 0.0}, (EpisodeSpec(3, ("design", 0, 0)),)))
    assert wide.images == 0
    assert "hfov_deg" in wide.failed
    assert "60" in wide.failed


def test_effects_act_at_their_stage_whatever_their_order(toys):
    def brightness(effects):
        evaluate = Evaluator(toy_recipe(effects=effects, nodes={"frames": {"sigma_dn": 0}}), toys)
        job = ScoreJob({"focal_length_mm": 1.0, "pitch_deg": 0.0}, (EpisodeSpec(3, ("design", 0, 0)),))
        return evaluate(job).scores["width.brightness"]

    dim, offset = {"use": "effect.toy-dim", "share": 0.5}, {"use": "effect.toy-offset", "offset_dn": 10.0}
    plain = brightness([])
    assert brightness([dim]) == pytest.approx(plain / 2, abs=1)
    assert brightness([offset]) == pytest.approx(plain + 10, abs=1)
    assert brightness([offset, dim]) == brightness([dim, offset]) == pytest.approx(plain / 2 + 10, abs=1)


def test_states_of_learning_tasks_go_through_the_study(toys, tmp_path):
    steps = {}
    for weights in ("shared", "branched", "frozen"):
        changed = {
            **LEARNER,
            "nodes": {"learner": {**LEARNER["nodes"]["learner"], "train": {"weights": weights}}},
        }
        result = run(toy_recipe(**changed), toys, tmp_path / weights)
        (kept,) = (tmp_path / weights / "weights").glob("designed.learner.*.safetensors")
        from safetensors.numpy import load_file

        steps[weights] = int(load_file(kept)["steps"][0])
        assert math.isfinite(result["test"]["designed"]["learner.knowledge"])
    assert steps == {"shared": 6 * 6 * 4, "branched": 6 * 4, "frozen": 0}  # six frames a training


def test_images_of_every_camera_and_of_training_are_counted(toys):
    evaluate = Evaluator(toy_recipe(**LEARNER), toys)
    states = evaluate.simulation.initial_states()
    job = ScoreJob(
        {"focal_length_mm": 1.0, "pitch_deg": 0.0},
        (EpisodeSpec(3, ("design", 0, 0)), EpisodeSpec(3, ("design", 0, 1), frames=4)),
        states,
        training=EpisodeSpec(3, ("train", 0, 0)),
    )
    evaluation = evaluate(job)
    assert evaluation.images == 6 + 6 + 4
    assert {"learner", "learner, training"} <= set(evaluation.seconds)  # scoring, and what it takes to learn
