"""One plan a run, and in a process every component is built once."""

from __future__ import annotations

import json
from collections import Counter

import pytest
import toy_plugin
from toy_study import LEARNER, merged, run, toy_recipe

from tacos_framework.cli import run_main
from tacos_framework.plan import make_plan
from tacos_framework.plugins import Plugins
from tacos_framework.simulation import EpisodeSpec, Evaluator, ScoreJob

CLASSES = ("ToyScene", "ToyRenderer", "ToySensor", "WidthTask", "Learner", "Mean", "Level")
SECTIONS = merged(
    LEARNER,
    {
        "nodes": {
            "mean": {"use": "transform.toy-mean", "in": {"frames": "frames"}, "gain": 1.0},
            "level": {"use": "task.toy-level", "in": {"levels": "mean"}},
        },
        "optimizer": {"generations": 2},
        "test": {"frames": None},  # another length of an episode is another scene
    },
)


@pytest.fixture
def built(monkeypatch):
    """How often each class of the toys was built."""
    counts: Counter[str] = Counter()
    for name in CLASSES:
        cls = getattr(toy_plugin, name)

        def counted(self, config, make=cls.__init__, name=name):
            counts[name] += 1
            make(self, config)

        monkeypatch.setattr(cls, "__init__", counted)
    return counts


def test_a_study_builds_every_node_once(toys, tmp_path, built):
    run(toy_recipe(**SECTIONS), toys, tmp_path / "out")
    assert built == dict.fromkeys(CLASSES, 1)


def test_a_plan_made_before_is_the_plan_that_is_run(toys, tmp_path, built, monkeypatch):
    plan = make_plan(toy_recipe(**SECTIONS), toys)
    assert built == dict.fromkeys(CLASSES, 1)
    result = run(plan, toys, tmp_path / "out")
    assert result["best"]["fitness"] is not None
    assert built == dict.fromkeys(CLASSES, 1)


def test_the_command_makes_one_plan(toys, tmp_path, built, monkeypatch):
    path = tmp_path / "r.yaml"
    path.write_text(json.dumps(toy_recipe(**SECTIONS).as_data()))
    monkeypatch.setattr(Plugins, "discover", lambda: toys)
    assert run_main([str(path), "--out", str(tmp_path / "out"), "--quiet"]) == 0
    assert built == dict.fromkeys(CLASSES, 1)


def test_only_what_a_candidate_sets_is_built_anew(toys, built):
    design = {"design": {"mean.gain": {"between": [1, 2]}}}
    evaluate = Evaluator(make_plan(toy_recipe(**merged(SECTIONS, design)), toys))
    states = evaluate.simulation.initial_states()
    values = {"focal_length_mm": 1.0, "pitch_deg": 0.0, "mean.gain": 1.5}
    evaluation = evaluate(ScoreJob(values, (EpisodeSpec(3, ("design", 0, 0)),), states))
    assert evaluation.fitness is not None
    assert built == {**dict.fromkeys(CLASSES, 1), "Mean": 2}
