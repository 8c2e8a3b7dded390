"""Pre-training: images of many cameras, weights that studies take, going on with a broken run."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import toy_detection
import toy_plugin
import yaml
from safetensors import safe_open
from safetensors.numpy import load_file
from toy_study import begun_as

from tacos_framework import ProcedureRecipe, UserError, load_recipe, run
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Recipe, Use
from tacos_framework.store import Results
from tacos_framework.testing import ProcedureConformance
from tacos_framework.testing.fingerprint import fingerprint
from tacos_framework.testing.samples import sample_rig
from tacos_plugins.pretraining import pretrain as pretrain_module
from tacos_plugins.pretraining.kept_frames import read_frames, write_frames

pytest.importorskip("torchvision", reason="the extra perception is not installed")

PROBLEM: dict[str, Any] = {
    "tacos": 1,
    "name": "squares",
    "seed": 3,
    "rig": {
        "use": "rig.monocular",
        "sensor": {"name": "small", "width_px": 48, "height_px": 32, "pixel_um": 100},
    },
    "design": {"focal_length_mm": {"between": [0.5, 10]}, "pitch_deg": {"between": [-30, 30]}},
    "constraints": {"hfov_deg": {"min": 40, "max": 120}},
    "nodes": {
        "world": {"use": "scene.squares", "frames": 3},
        "capture": {"use": "renderer.squares", "in": {"episode": "world"}},
        "frames": {"use": "sensor.toy", "in": {"capture": "capture"}},
        "detect": {
            "use": "task.faster-rcnn",
            "in": {"frames": "frames"},
            "backbone": "narrow-fpn",
            "proposals": 20,
            "rois": 8,
            "device": "cpu",
        },
    },
    "fitness": [{"score": "detect.ap50", "weight": 1}],
    "optimizer": {"use": "optimizer.genetic"},
    "test": {"seed": 9, "frames": 2, "episodes": 1},
}


@pytest.fixture(scope="module")
def plugins() -> Plugins:
    found = Plugins.discover()
    found.register(toy_plugin)
    found.register(toy_detection)
    return found


@pytest.fixture(scope="module")
def problem(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("problem") / "squares.yaml"
    path.write_text(yaml.safe_dump(PROBLEM))
    return path


def asked(path: Path, seed: int = 5, **settings: Any) -> ProcedureRecipe:
    base: dict[str, Any] = {
        "problem": str(path),
        "change": {"nodes.detect.batch_norm": "update"},
        "images": 10,
        "held_out": 4,
        "images_per_world": 4,
        "cameras_per_world": 2,
        "epochs": 3,
        "score_every": 2,
        "train": {"learning_rate": 1e-3},
        "file": "squares",
    }
    return ProcedureRecipe(
        "procedure.pretrain", base | settings, name="p", seed=seed, executor=Use(use="executor.local")
    )


@pytest.fixture(scope="module")
def done(problem, plugins, tmp_path_factory) -> tuple[dict[str, Any], Path]:
    out = tmp_path_factory.mktemp("done") / "out"
    return run(asked(problem), out=out, plugins=plugins), out


def test_it_trains_on_as_many_images_as_asked_and_scores_on_others(done):
    result, out = done
    assert (result["images"], result["held_out"], result["epochs"]) == (10, 4, 3)
    lines = [json.loads(line) for line in (out / "epochs.jsonl").read_text().splitlines()]
    assert [bool(line["scores"]) for line in lines] == [False, True, True]
    assert all(line["losses"]["loss"] > 0 for line in lines)
    assert result["scores"] == lines[-1]["scores"]
    assert "ap50" in result["scores"]
    assert "weights/squares.safetensors" in result["summary"]
    page = (out / "report.html").read_text()
    assert page.count("<svg") == 4, "each once more for phones"
    assert 'src="http' not in page


def test_the_weights_alone_are_left_and_a_study_takes_them(done, plugins, problem, tmp_path):
    _, out = done
    (file,) = (out / "weights").iterdir()
    recipe = yaml.safe_load(problem.read_text())
    recipe["nodes"]["detect"]["weights"] = str(file)
    recipe["optimizer"] |= {"population": 2, "keep": 1, "parents": 2, "generations": 1}
    study = Recipe.model_validate(recipe)
    run(study, out=tmp_path / "study", plugins=plugins, report=False)
    (kept,) = (tmp_path / "study" / "weights").glob("designed.detect.*")
    weights, state = load_file(file), load_file(kept)
    assert {f"model.{name}" for name in weights} == {name for name in state if name.startswith("model.")}
    assert all(np.array_equal(state[f"model.{name}"], array) for name, array in weights.items())


def test_the_file_says_how_it_was_made(done, problem):
    _, out = done
    with safe_open(out / "weights" / "squares.safetensors", "numpy") as opened:
        about = opened.metadata()
    assert about["seed"] == "5"
    assert json.loads(about["recipe"])["images"] == 10
    assert json.loads(about["settings"])["backbone"] == "narrow-fpn"
    assert json.loads(about["scores"])["ap50"] >= 0


def test_half_precision_halves_the_file(done, problem, plugins, tmp_path):
    result = run(asked(problem, precision="float16", epochs=1), out=tmp_path / "half", plugins=plugins)
    assert result["weights_bytes"] == pytest.approx(done[0]["weights_bytes"] / 2, rel=0.05)


@pytest.mark.parametrize("breaks_in", [2, 3])
def test_a_broken_run_goes_on_to_the_same_weights(done, problem, plugins, tmp_path, monkeypatch, breaks_in):
    whole, finished = done
    out = tmp_path / "broken"
    scores = pretrain_module._scores

    def die(*arguments: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr(pretrain_module, "_scores", die)
    if breaks_in == 3:
        calls = iter([scores, die])
        monkeypatch.setattr(pretrain_module, "_scores", lambda *given: next(calls)(*given))
    with pytest.raises(KeyboardInterrupt):
        run(asked(problem), out=out, plugins=plugins)
    monkeypatch.setattr(pretrain_module, "_scores", scores)
    assert len((out / "epochs.jsonl").read_text().splitlines()) == breaks_in - 1
    resumed = run(asked(problem), out=out, plugins=plugins, resume=True)
    one, other = (load_file(folder / "weights" / "squares.safetensors") for folder in (finished, out))
    assert fingerprint(one) == fingerprint(other)
    assert resumed["scores"] == whole["scores"]


def test_images_that_are_there_are_not_rendered_again(done, problem, plugins, tmp_path):
    _, finished = done
    out = begun_as(finished, tmp_path / "again")
    Results(out).remove("epochs.jsonl")
    (finished / "frames").rename(out / "frames")
    try:
        before = {path.name: path.stat().st_mtime_ns for path in (out / "frames").iterdir()}
        run(asked(problem), out=out, plugins=plugins, resume=True)
        assert {path.name: path.stat().st_mtime_ns for path in (out / "frames").iterdir()} == before
    finally:
        (out / "frames").rename(finished / "frames")


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"seed": 3}, "3 is also the seed of"),
        ({"seed": 9}, "9 is also the test.seed of"),
        ({"node": "detec"}, "Did you mean 'detect'"),
        ({"train": {"learning_rat": 1}}, "Did you mean 'learning_rate'"),
        ({"problem": "optimizers_compared"}, "is no study"),
        ({"change": {"constraints.hfov_deg": {"min": 200}}}, "cameras tried keeps it"),
    ],
)
def test_what_cannot_be_trained_is_refused(problem, plugins, tmp_path, settings, said):
    with pytest.raises(UserError) as caught:
        run(asked(problem, **settings), out=tmp_path / "out", plugins=plugins)
    assert said in str(caught.value)


def test_kept_frames_give_back_images_depth_ids_and_classes(tmp_path):
    frames = toy_detection.squares(3)
    write_frames(tmp_path / "kept.npz", frames)
    back = read_frames(tmp_path / "kept.npz", sample_rig(width_px=64, height_px=48))
    assert np.array_equal(back.images[0], frames.images[0])
    for name in ("object_id", "depth_m", "world_from_camera"):
        assert np.array_equal(getattr(back.capture.views[0], name), getattr(frames.capture.views[0], name))
    assert back.episode.world.class_names == frames.episode.world.class_names
    assert back.episode.world.objects == frames.episode.world.objects
    assert (back.black_level_dn, back.white_level_dn) == (0.0, 255.0)
    assert not back.capture.views[0].luminance_cd_m2.any()
    assert [path.name for path in tmp_path.iterdir()] == ["kept.npz"]


class TestPretrain(ProcedureConformance):
    component = pretrain_module.Pretrain
    files = ("report.html", "epochs.jsonl", "weights/squares.safetensors")

    @pytest.fixture(autouse=True)
    def _on_a_toy(self, problem, plugins):
        self.config = asked(problem, epochs=1, images=4).settings  # type: ignore[misc]
        self.plugins = plugins

    def comparable(self, result: Mapping[str, Any]) -> Mapping[str, Any]:
        return {key: value for key, value in super().comparable(result).items() if key != "training_seconds"}


TINY = {
    "images": 4,
    "held_out": 2,
    "images_per_world": 2,
    "cameras_per_world": 1,
    "epochs": 1,
    "score_every": 1,
}


@pytest.mark.slow
@pytest.mark.gl
@pytest.mark.parametrize(
    ("name", "change"),
    [
        (
            "pretrain_detector_resnet50",
            {
                "nodes.detect.weights": "none",
                "nodes.world.size_m": [5, 5],
                "nodes.capture.light_texel_m": 0.3,
                "constraints.hfov_deg": {"min": 40, "max": 140},
                "rig.binning": 32,
            },
        ),
        (
            "pretrain_stereo_psmnet",
            {
                "nodes.world.blocks": 1,
                "nodes.world.reach_m": 60,
                "nodes.world.texture_px": 64,
                "nodes.capture.light_texel_m": 2.0,
                "nodes.stereo.max_disparity": 32,
                "rig.binning": 8,
            },
        ),
    ],
)
def test_recipes_of_the_papers_networks_run_cut_down_on_a_cpu(tmp_path, name, change):
    recipe = load_recipe(name, {"change": change, **TINY})
    result = run(recipe, out=tmp_path / "out")
    assert result["images"] == 4 * (2 if "stereo" in name else 1)
    assert all(np.isfinite(loss) for loss in result["losses"].values())
    assert (tmp_path / "out" / result["weights"]).is_file()
