"""`task.psmnet` in a study: weights that move with the cameras, and candidates on which training fails."""

from __future__ import annotations

import json

import numpy as np
import pytest
from safetensors.numpy import load_file

import tacos_framework
from tacos_framework.errors import UserError
from tacos_framework.plan import make_plan
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Recipe
from tacos_framework.testing.fingerprint import fingerprint

torch = pytest.importorskip("torch", reason="the extra perception is not installed")

from tacos_plugins.tasks.psmnet import training  # noqa: E402


def recipe(batch: int, stereo_weights: str = "none", **train) -> Recipe:
    return Recipe.model_validate(
        {
            "name": "stereo in small",
            "seed": 3,
            "rig": {
                "use": "rig.stereo",
                "sensor": {"name": "tiny", "width_px": 64, "height_px": 32, "pixel_um": 3.0},
            },
            "design": {"baseline_m": {"between": [0.05, 0.5]}, "hfov_deg": {"between": [50, 90]}},
            "nodes": {
                "world": {"use": "scene.textured-target", "texture_px": 128, "distance_m": 2.0, "frames": 4},
                "capture": {"use": "renderer.analytic", "in": {"episode": "world"}},
                "frames": {"use": "sensor.affine-noise", "in": {"capture": "capture"}},
                "stereo": {
                    "use": "task.psmnet",
                    "in": {"frames": "frames"},
                    "width": 0.1,
                    "max_disparity": 16,
                    "device": "cpu",
                    "weights": stereo_weights,
                    "train": train,
                },
            },
            "fitness": [{"score": "stereo.inverse_log_error", "weight": 1}],
            "optimizer": {"use": "optimizer.random", "evaluations": 3, "batch": batch},
        }
    )


def study(out, *, batch: int, resume: bool = False, **changes):
    plugins = Plugins.discover()
    tacos_framework.run(recipe(batch, **changes), out=out, plugins=plugins, report=False, resume=resume)


def run(out, *, batch: int = 3, resume: bool = False, **changes):
    """The candidates of all generations, and the weights after the last."""
    study(out, batch=batch, resume=resume, **changes)
    lines = (out / "generations.jsonl").read_text().splitlines()
    (weights,) = (out / "weights").iterdir()
    return [candidate for line in lines for candidate in json.loads(line)["candidates"]], load_file(weights)


def test_weights_follow_the_cameras(tmp_path):
    candidates, weights = run(tmp_path / "out", weights="shared")
    assert all(candidate["failed"] is None for candidate in candidates)
    assert set(weights["adam.step"].tolist()) == {3.0}


def test_frozen_weights_stay(tmp_path):
    run(tmp_path / "before", weights="shared")
    (file,) = (tmp_path / "before" / "weights").iterdir()
    _, weights = run(tmp_path / "out", stereo_weights=str(file), weights="frozen")
    assert not weights["adam.step"].any()
    kept = load_file(file)
    assert all(np.array_equal(weights[n], kept[n]) for n in weights if n.startswith("model."))


def test_frozen_weights_that_were_never_trained_are_refused():
    with pytest.raises(UserError, match="never trained: weights is none") as raised:
        make_plan(recipe(3, weights="frozen"), Plugins.discover())
    (fault,) = raised.value.faults
    assert "nodes.stereo.train.weights" in fault.where
    assert "pretrain_stereo" in fault.what
    assert "Name such weights" in fault.remedy


def test_a_candidate_on_which_training_diverges_fails_alone(tmp_path, monkeypatch):
    """The second candidate's loss is no number; the third goes on from the weights of the first."""
    real, steps = training.disparity_loss, []

    def loss(*args):
        steps.append(1)
        return real(*args) * (float("nan") if len(steps) == 2 else 1.0)

    monkeypatch.setattr(training, "disparity_loss", loss)
    candidates, weights = run(tmp_path / "out", weights="shared")
    reasons = [candidate["failed"] for candidate in candidates]
    assert reasons[0] is reasons[2] is None
    assert "training of task.psmnet diverged: its loss is nan at step 1" in reasons[1]
    assert set(weights["adam.step"].tolist()) == {2.0}
    assert all(np.isfinite(array).all() for array in weights.values())


def test_a_study_that_was_broken_off_ends_with_the_same_weights(tmp_path, monkeypatch):
    candidates, weights = run(tmp_path / "whole", batch=1, weights="shared")
    real, steps = training.disparity_loss, []

    def loss(*args):
        steps.append(1)
        if len(steps) == 3:
            raise KeyboardInterrupt
        return real(*args)

    monkeypatch.setattr(training, "disparity_loss", loss)
    study(tmp_path / "broken", batch=1, weights="shared")  # may leave weights that nothing names any more
    assert len(steps) == 3
    resumed, resumed_weights = run(tmp_path / "broken", batch=1, weights="shared", resume=True)
    assert resumed == candidates
    assert fingerprint(dict(resumed_weights)) == fingerprint(dict(weights))
