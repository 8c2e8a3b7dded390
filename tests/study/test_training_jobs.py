"""What a task that learns is shown: which worlds during the search, and how often the camera that won."""

from __future__ import annotations

import pytest
from safetensors.numpy import load_file
from toy_study import LEARNER, merged, run, toy_recipe

import tacos_framework

GENERATIONS, POPULATION = 3, 4
FRAMES = 6
COMPARE = {"cameras": ["flea3"], "evaluations": 2}


class Recorder:
    """An executor that notes what the candidates are trained on."""

    def __init__(self):
        self.trainings = []

    def map(self, evaluate, jobs):
        self.trainings += [job.value.training for job in jobs if getattr(job.value, "training", None)]
        return map(evaluate, jobs)


def training_episodes(toys, folder, weights, compare=None, **study):
    changes = {
        "rig": {"binning": 200},
        "compare": compare,
        "study": study,
        "optimizer": {"generations": GENERATIONS, "population": POPULATION},
        "nodes": {"learner": {"train": {"weights": weights}}},
    }
    recorder = Recorder()
    recipe = toy_recipe(**merged(LEARNER, changes))
    tacos_framework.run(recipe, plugins=toys, out=folder, executor=recorder, report=False)
    return recorder.trainings


@pytest.mark.parametrize("weights", ["shared", "branched"])
@pytest.mark.parametrize(
    ("renewed", "worlds"),
    [("never", 1), ("each_generation", GENERATIONS), ("each_candidate", GENERATIONS * POPULATION)],
)
def test_training_sees_as_many_worlds_as_asked_for(toys, tmp_path, weights, renewed, worlds):
    trainings = training_episodes(
        toys, tmp_path / "out", weights, renew_episodes="never", renew_training=renewed
    )
    assert len(trainings) == GENERATIONS * POPULATION
    assert len(set(trainings)) == worlds


@pytest.mark.parametrize(("renewed", "worlds"), [("never", 1), ("each_generation", GENERATIONS)])
def test_by_default_training_is_renewed_with_the_episodes(toys, tmp_path, renewed, worlds):
    assert len(set(training_episodes(toys, tmp_path / "out", "shared", renew_episodes=renewed))) == worlds


@pytest.mark.parametrize("rounds", [2, 7, 12])
def test_products_learn_in_the_worlds_of_the_design(toys, tmp_path, rounds):
    changes = {
        "rig": {"binning": 200},
        "compare": {"cameras": ["flea3"], "evaluations": rounds},
        "study": {"renew_episodes": "each_generation"},
        "optimizer": {"generations": GENERATIONS, "population": POPULATION},
    }
    recipe = toy_recipe(**merged(LEARNER, changes))
    recipe = recipe.model_copy(update={"design": {"focal_length_mm": recipe.design["focal_length_mm"]}})
    recorder = Recorder()
    tacos_framework.run(recipe, plugins=toys, out=tmp_path / "out", executor=recorder, report=False)
    count = GENERATIONS * POPULATION
    of_design, of_product = recorder.trainings[:count], recorder.trainings[count:]
    assert len(of_product) == rounds
    assert set(of_product) <= set(of_design)
    assert len(set(of_product)) == min(rounds, GENERATIONS)


def test_nothing_is_trained_where_the_weights_are_frozen(toys, tmp_path):
    assert training_episodes(toys, tmp_path / "out", "frozen", renew_training="each_candidate") == []


@pytest.mark.parametrize(("weights", "trainings"), [("shared", 3), ("branched", 3), ("frozen", 0)])
def test_the_network_of_each_camera_is_trained_on_it_before_the_test(toys, tmp_path, weights, trainings):
    searched = training_episodes(toys, tmp_path / "searched", weights, compare=COMPARE)
    trained = training_episodes(toys, tmp_path / "trained", weights, compare=COMPARE, train_best=3)
    added = trained[len(searched) :]
    assert trained[: len(searched)] == searched
    assert len(added) == trainings * 2  # of the designed camera, and of the one off the shelf
    assert len(set(added)) == trainings
    assert not set(added) & set(searched)


def test_training_on_the_best_changes_no_camera_and_is_what_the_test_sees(toys, tmp_path):
    shared = merged(LEARNER, {"optimizer": {"generations": 2}, "compare": COMPARE, "rig": {"binning": 200}})
    results, steps = {}, {}
    for trainings in (0, 3):
        recipe = toy_recipe(**shared, study={"train_best": trainings})
        results[trainings] = run(recipe, toys, tmp_path / str(trainings))
        files = (tmp_path / str(trainings) / "weights").glob("designed.learner.*.safetensors")
        kept = max(files, key=lambda file: int(file.stem.rpartition(".")[2]))
        steps[trainings] = int(load_file(kept)["steps"][0])
    searched, trained = results[0], results[3]
    assert steps[3] == steps[0] + 3 * FRAMES  # frames come one by one
    assert trained["best"] == searched["best"]
    assert any("trained 3 times more on each camera" in note for note in trained["notes"])
    assert not any("times more" in note for note in searched["notes"])
    assert trained["frames_rendered"] == searched["frames_rendered"] + 2 * 3 * FRAMES
    for camera in ("designed", "flea3"):
        before, after = (r["test"][camera] for r in (searched, trained))
        assert after["width.closeness"] == before["width.closeness"]
        assert after["learner.knowledge"] != before["learner.knowledge"]
