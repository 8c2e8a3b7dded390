"""The stereo recipes: what they say of the paper, and a study in small from end to end."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tacos_framework import Recipe, load_recipe, run
from tacos_framework.packaged_resources import shipped_folder
from tacos_framework.plan import Plan, make_plan
from tacos_framework.plugins import Plugins


def planned(name: str, **sets: object) -> Plan:
    recipe = load_recipe(name, {key.replace("__", "."): value for key, value in sets.items()})
    assert isinstance(recipe, Recipe)
    return make_plan(recipe, Plugins.discover())


def test_stereo_car_is_the_papers_study() -> None:
    plan = planned("stereo_car")
    recipe = plan.recipe
    assert {name: tuple(entry.between) for name, entry in recipe.design.items()} == {
        "baseline_m": (0.01, 3),
        "hfov_deg": (50, 120),
    }
    optimizer = recipe.optimizer.settings
    assert {key: optimizer[key] for key in ("population", "keep", "parents")} == {
        "population": 5,
        "keep": 2,
        "parents": 3,
    }
    assert optimizer["add"] == {"baseline_m": 0.2, "hfov_deg": 5}
    assert optimizer["population"] * optimizer["generations"] == 1000
    assert recipe.nodes["stereo"].train is not None
    assert recipe.test is not None
    assert recipe.test.frames == 1500
    assert recipe.test.seed != recipe.seed  # another map
    assert [camera.name for camera in plan.cameras] == ["realsense_d450", "zed_2i"]
    sensor = plan.rig_variables({"baseline_m": 1.6, "hfov_deg": 50.0}).sensor
    assert (sensor.width_mm, sensor.height_mm) == pytest.approx((1.536, 0.767), abs=1e-3)


def test_shipped_weights_fit_the_recipe_that_names_them_and_say_how_they_were_made() -> None:
    safetensors = pytest.importorskip("safetensors", reason="comes with the extra perception")
    pytest.importorskip("torch", reason="comes with the extra perception")
    plan = planned("stereo_joint_quick")
    name = plan.recipe.nodes["stereo"].settings["weights"]
    file = shipped_folder("catalogs") / "weights" / f"{name}.safetensors"
    with safetensors.safe_open(file, "numpy") as opened:
        about = opened.metadata()
    assert about["task"] == "task.psmnet"
    assert about["seed"] not in (str(plan.recipe.seed), str(plan.recipe.test.seed))  # other towns
    assert float(json.loads(about["scores"])["log_error"]) < 0.3
    assert file.stat().st_size < 1e6
    state = plan.nodes["stereo"].make().initial_state(rng=np.random.default_rng(0))
    assert any(np.abs(array).max() > 0 for array in state.values())


@pytest.mark.gl
def test_a_small_stereo_study_runs_and_compares_itself(tmp_path) -> None:
    small = {
        "rig.binning": 8,
        "nodes.world.blocks": 1,
        "nodes.world.reach_m": 60,
        "nodes.world.texture_px": 64,
        "nodes.world.frames": 2,
        "nodes.world.driving_cars": 1,
        "nodes.capture.light_texel_m": 2.0,
        "nodes.stereo.max_disparity": 32,
        "optimizer.evaluations": 6,
        "study": {"renew_episodes": "never"},
        "executor": {"use": "executor.local"},
        "test": {"seed": 1001, "frames": 2, "episodes": 1},
    }
    result = run(load_recipe("stereo_quick", small), out=tmp_path / "out")
    assert set(result["test"]) == {"designed", "realsense_d450", "zed_2i"}
    for scores in result["test"].values():
        assert 0 < scores["stereo.log_error"] < 3
        assert scores["fitness"] == pytest.approx(1 / scores["stereo.log_error"])
        assert scores["stereo.rmse_all_m"] > 0
    assert "stereo.log_error" in result["lower_is_better"]
    assert "stereo.inverse_log_error" not in result["lower_is_better"]
    assert (tmp_path / "out" / "report.html").exists()
