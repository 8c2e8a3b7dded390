"""Studies with a detector in the loop: joint, branched, frozen, broken off."""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np
import pytest
import toy_detection
import toy_plugin
from safetensors.numpy import load_file, save_file
from toy_study import comparable, run, toy_recipe

from tacos_framework.errors import UserError
from tacos_framework.plan import make_plan
from tacos_framework.plugins import Plugins
from tacos_framework.recipe.loading import load_recipe
from tacos_framework.simulation import Evaluator
from tacos_framework.store.database import DATABASE, Database
from tacos_framework.store.run import CHECKPOINT

pytest.importorskip("torchvision", reason="the extra perception is not installed")

from tacos_plugins.tasks.faster_rcnn import training as training_module


@pytest.fixture(scope="module")
def plugins() -> Plugins:
    found = Plugins.discover()
    found.register(toy_plugin)
    found.register(toy_detection)
    return found


def joint_recipe(weights="shared", start="none", **train):
    return toy_recipe(
        rig={"sensor": {"name": "small", "width_px": 48, "height_px": 32, "pixel_um": 100}},
        nodes={
            "world": {"use": "scene.squares", "frames": 2},
            "capture": {"use": "renderer.squares"},
            "detect": {
                "use": "task.faster-rcnn",
                "in": {"frames": "frames"},
                "backbone": "narrow-fpn",
                "classes": ["sofa", "bed"],
                "batch_norm": "update",
                "proposals": 20,
                "rois": 8,
                "device": "cpu",
                "weights": str(start),
                "train": {"weights": weights, "learning_rate": 1e-3, **train},
            },
        },
        fitness=[{"score": "width.closeness", "weight": 1}, {"score": "detect.ap50", "weight": 1}],
        optimizer={"population": 2, "keep": 1, "parents": 2, "generations": 2},
        test={"frames": 2, "episodes": 1},
    )


def kept_state(out):
    (file,) = (out / "weights").glob("designed.detect.*.safetensors")
    return load_file(file)


def first_state(recipe, plugins):
    return Evaluator(recipe, plugins).simulation.initial_states()["detect"]


def trained(folder, plugins):
    """A file of weights."""
    save_file(dict(first_state(joint_recipe(), plugins)), folder / "trained.safetensors")
    return folder / "trained.safetensors"


@pytest.mark.parametrize("start", ["none", "coco"])
def test_frozen_weights_that_do_not_know_the_classes_are_refused(plugins, start):
    recipe = joint_recipe("frozen", start=start)
    with pytest.raises(UserError, match=f"never trained: weights is {start}") as raised:
        make_plan(recipe, plugins)
    assert ["nodes.detect.train.weights" in fault.where for fault in raised.value.faults] == [True]


def test_weights_that_learn_may_start_at_random(plugins):
    assert make_plan(joint_recipe("branched"), plugins).trainable == ("detect",)


@pytest.mark.parametrize(("weights", "trainings"), [("shared", 4), ("branched", 2), ("frozen", 0)])
def test_weights_move_as_often_as_the_recipe_says(plugins, tmp_path, weights, trainings):
    recipe = joint_recipe(weights, start=trained(tmp_path, plugins) if weights == "frozen" else "none")
    result = run(recipe, plugins, tmp_path / "out")
    before, after = first_state(recipe, plugins), kept_state(tmp_path / "out")
    moved = [n for n in before if n.startswith("model.") and not np.array_equal(before[n], after[n])]
    assert after["schedule.steps"].tolist() == [trainings]
    assert bool(moved) is (trainings > 0)
    assert 0 <= result["test"]["designed"]["detect.ap50"] <= 1


class Killed(BaseException):
    """Ends a study as a signal would: nothing is caught, nothing written any more."""


class DiesAfter:
    """An executor that lets so many jobs be done."""

    workers = 1

    def __init__(self, jobs: int):
        self._left = jobs

    def map(self, evaluate, jobs) -> Iterator[object]:
        for job in jobs:
            if not self._left:
                raise Killed
            self._left -= 1
            yield evaluate(job)

    def close(self) -> None:
        """Nothing to let go of."""


def test_a_joint_study_killed_in_the_middle_goes_on_bit_for_bit(plugins, tmp_path):
    recipe = joint_recipe("shared")
    whole = run(recipe, plugins, tmp_path / "whole")
    with pytest.raises(Killed):
        # two candidates trained and scored, two only trained
        run(recipe, plugins, tmp_path / "killed", executor=DiesAfter(6))
    with Database(tmp_path / "killed" / DATABASE, read_only=True) as database:
        checkpoint = database.get(CHECKPOINT, 0)
    assert checkpoint["searches"]["designed"]["generation"] == 1
    resumed = run(recipe, plugins, tmp_path / "killed", resume=True)
    assert comparable(resumed) == comparable(whole)
    one, other = kept_state(tmp_path / "whole"), kept_state(tmp_path / "killed")
    assert one.keys() == other.keys()
    assert all(one[name].tobytes() == other[name].tobytes() for name in one)


def test_a_candidate_whose_training_diverges_fails_and_the_weights_roll_back(plugins, tmp_path, monkeypatch):
    calls = []
    finite = training_module.finite

    def diverging_once(loss, *, step, where):
        calls.append(step)
        return finite(loss * np.nan if len(calls) == 2 else loss, step=step, where=where)

    monkeypatch.setattr(training_module, "finite", diverging_once)
    result = run(joint_recipe("shared"), plugins, tmp_path / "out")
    lines = [json.loads(line) for line in (tmp_path / "out" / "generations.jsonl").read_text().splitlines()]
    failed = [c["failed"] for line in lines for c in line["candidates"] if c["failed"]]
    assert failed == ["training of task.faster-rcnn diverged: its loss is nan at step 0"]
    assert result["best"] is not None
    after = kept_state(tmp_path / "out")
    assert after["schedule.steps"].tolist() == [3]  # of four candidates
    assert all(np.all(np.isfinite(array)) for array in after.values())


def test_keys_under_train_are_checked_with_the_recipe(plugins):
    with pytest.raises(UserError) as caught:
        make_plan(joint_recipe(learning_rat=1, batch_size=0), plugins)
    said = str(caught.value)
    assert "nodes.detect.train.learning_rat" in said
    assert "Did you mean 'learning_rate'" in said
    assert "batch_size is 0" in said


@pytest.mark.slow
@pytest.mark.gl
@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("headset_joint_quick", {"nodes.world.frames": 8, "rig.binning": 8, "study.episodes": 1}),
        ("headset_day", {"nodes.world.frames": 3, "rig.binning": 40}),
    ],
)
def test_shipped_recipes_train_their_detector(tmp_path, name, changes):
    short = {"use": "optimizer.genetic", "population": 2, "keep": 1, "parents": 2, "generations": 1}
    recipe = load_recipe(
        name, {**changes, "optimizer": short, "compare": None, "test": {"frames": 4, "episodes": 1}}
    )
    plugins = Plugins.discover()
    run(recipe, plugins, tmp_path / "out")
    before, after = first_state(recipe, plugins), kept_state(tmp_path / "out")
    assert after["schedule.steps"].tolist() == [2 * recipe.nodes["detect"].train.epochs]
    head = "model.roi_heads.box_predictor.cls_score.weight"
    assert np.abs(after[head] - before[head]).max() > 0
