"""Graphs that recipes may ask for: an ISP designed with the lens, branches of one renderer, day and night."""

from __future__ import annotations

import functools
import json

import pytest
import toy_plugin
from toy_study import merged, run

from tacos_framework.plan import make_plan
from tacos_framework.recipe import Recipe, parse_recipe
from tacos_framework.simulation import EpisodeSpec, Evaluator, ScoreJob
from tacos_plugins.renderers.analytic import AnalyticRenderer

DETECTOR = {"name": "small", "width_px": 160, "height_px": 120, "pixel_um": 20}
BASE = {
    "tacos": 1,
    "name": "a graph",
    "seed": 3,
    "rig": {"use": "rig.monocular", "sensor": DETECTOR, "pitch_deg": 0},
    "design": {"focal_length_mm": {"between": [1.5, 4]}},
    "scenario": {"illumination_lux": 30},
    "nodes": {
        "world": {"use": "scene.chessboard", "frames": 2},
        "light": {"use": "renderer.analytic", "in": {"episode": "world"}},
        "raw": {"use": "sensor.affine-noise", "in": {"capture": "light"}},
        "features": {"use": "task.orb-features", "in": {"frames": "raw"}},
        "width": {"use": "task.toy-width", "in": {"frames": "raw"}},
    },
    "fitness": [{"score": "width.closeness", "weight": 1}, {"score": "width.brightness", "weight": 0.001}],
    "optimizer": {"use": "optimizer.random", "evaluations": 3, "batch": 3},
    "study": {"renew_episodes": "never"},
}
NOISY = {"nodes": {"raw": {"use": "sensor.toy", "sigma_dn": 4}}}
ISP = {
    "design": {"tone.gamma": {"between": [1, 3]}, "clean.strength": {"between": [0, 1.5]}},
    "nodes": {
        "clean": {"use": "effect.denoise", "in": {"frames": "raw"}},
        "tone": {"use": "effect.tone-curve", "in": {"frames": "clean"}},
        "features": {"in": {"frames": "tone"}},
        "width": {"in": {"frames": "tone"}},
    },
}
BRANCHES = {
    "nodes": {
        "dim": {"use": "effect.vignetting", "in": {"capture": "light"}, "k1": -0.5},
        "cheap": {"use": "sensor.toy", "in": {"capture": "dim"}},
        "tone": {"use": "effect.tone-curve", "in": {"frames": "raw"}, "gamma": 2.2},
        "jpeg": {"use": "effect.jpeg", "in": {"frames": "cheap"}, "quality": 20},
        "features": {"in": {"frames": "tone"}},
        "width": {"in": {"frames": "jpeg"}},
    },
    "fitness": [{"score": "width.brightness", "weight": 1}],
}
SETTLING_TWICE = {
    "effects": [{"use": "effect.auto-white-balance", "red_first": 3.0}],
    "nodes": {
        "raw": {"use": "sensor.toy", "sigma_dn": 0},
        "again": {"use": "sensor.toy", "sigma_dn": 0, "in": {"capture": "light"}},
        "width_again": {"use": "task.toy-width", "in": {"frames": "again"}},
    },
}
DAY_AND_NIGHT = {
    "scenario": [
        {"name": "day", "illumination_lux": 2000, "exposure_ms": 5},
        {"name": "night", "illumination_lux": 2, "weight": 2},
    ],
    "fitness": [{"score": "width.brightness", "weight": 1}],
    "design": {"scenario.night.exposure_ms": {"between": [5, 40]}},
}


def recipe(*changes) -> Recipe:
    data = BASE
    for change in changes:
        data = merged(data, change)
    read, faults = parse_recipe(json.dumps(data), name="recipe.yaml")
    assert not faults, "\n".join(map(str, faults))
    return read


def evaluated(toys, changes, **values):
    evaluate = Evaluator(make_plan(recipe(*changes), toys), toys)
    return evaluate(ScoreJob({"focal_length_mm": 2.0, **values}, (EpisodeSpec(3, ("design", 0, 0)),)))


def test_an_isp_is_designed_beside_the_lens(toys, tmp_path):
    result = run(recipe(NOISY, ISP), toys, tmp_path / "out")
    assert set(result["best"]["camera"]) == {"focal_length_mm", "tone.gamma", "clean.strength"}
    assert {"clean", "tone"} < set(result["seconds_by_node"])
    flat = {"clean.strength": 0.0}
    off, dark = (evaluated(toys, [NOISY, ISP], **{"tone.gamma": gamma, **flat}) for gamma in (1.0, 3.0))
    assert dark.scores["width.brightness"] < 0.99 * off.scores["width.brightness"]
    plain = evaluated(toys, [NOISY])
    assert off.scores == plain.scores  # an ISP that is off is none
    clean = evaluated(toys, [NOISY, ISP], **{"tone.gamma": 1.0, "clean.strength": 1.5})
    assert clean.scores != plain.scores


def test_two_sensors_and_two_isps_feed_two_tasks_from_one_renderer(toys, monkeypatch):
    frames = []
    capture = AnalyticRenderer.capture

    @functools.wraps(capture)
    def counted(self, episode, **supplied):
        frames.append(len(episode))
        return capture(self, episode, **supplied)

    monkeypatch.setattr(AnalyticRenderer, "capture", counted)
    both = evaluated(toys, [BRANCHES])
    assert sum(frames) == 2
    seen = {
        name: evaluated(toys, [{"nodes": {**nodes, name: BRANCHES["nodes"][name]}, "fitness": fitness}])
        for name, nodes, fitness in (
            ("features", {"tone": BRANCHES["nodes"]["tone"]}, [{"score": "features.inliers", "weight": 1}]),
            (
                "width",
                {key: BRANCHES["nodes"][key] for key in ("dim", "cheap", "jpeg")},
                BRANCHES["fitness"],
            ),
        )
    }
    for name, alone in seen.items():  # a branch sees what it would see by itself
        own = {key: value for key, value in both.scores.items() if key.startswith(name)}
        assert own == {key: alone.scores[key] for key in own}
    assert both.scores["width.brightness"] != seen["features"].scores["width.brightness"]


@pytest.mark.parametrize("over", ["mean", "worst"])
def test_day_and_night_in_one_study(toys, tmp_path, over):
    result = run(
        recipe(DAY_AND_NIGHT, {"study": {"scenarios": over, "finalists": 1}}), toys, tmp_path / "out"
    )
    best = result["best"]
    day, night = (best["scenarios"][name]["fitness"] for name in ("day", "night"))
    assert night < day
    assert best["fitness"] == pytest.approx(night if over == "worst" else (day + 2 * night) / 3)
    tried = json.loads((tmp_path / "out" / "generations.jsonl").read_text().splitlines()[0])["candidates"]
    assert best["fitness"] == max(candidate["fitness"] for candidate in tried)


def test_an_effect_that_remembers_does_so_at_each_sensor_by_itself(toys):
    """Two equal sensors take equal frames: neither counts those of the other."""
    scores = evaluated(toys, [SETTLING_TWICE]).scores
    assert scores["width_again.brightness"] == scores["width.brightness"]


def test_a_scenario_s_own_setting_changes_that_scenario_alone(toys):
    short, long = (
        evaluated(toys, [DAY_AND_NIGHT], **{"scenario.night.exposure_ms": time_ms}).scenarios
        for time_ms in (5.0, 40.0)
    )
    assert long["night"]["fitness"] > 4 * short["night"]["fitness"]
    assert long["day"] == short["day"]


def test_an_effect_as_a_node_does_what_it_does_under_effects(toys):
    """Light, samples inside the sensor, and files: each at its stage."""
    for use, node in (
        ({"use": "effect.vignetting", "k1": -0.5}, {"in": {"capture": "light"}}),
        ({"use": "effect.toy-offset", "offset_dn": 9.0}, {"in": {"capture": "light"}}),
        ({"use": "effect.jpeg", "quality": 20}, {"in": {"frames": "raw"}}),
    ):
        into, last = ("raw", "raw") if "capture" in node["in"] else ("width", "changed")
        wired = {
            "changed": {**use, **node},
            into: {"in": {"capture" if into == "raw" else "frames": "changed"}},
        }
        as_node = evaluated(toys, [{"nodes": wired}])
        listed = evaluated(toys, [{"effects": [use]}])
        assert as_node.scores["width.brightness"] == listed.scores["width.brightness"], (use, last)
        assert as_node.scores != evaluated(toys, []).scores


def test_each_camera_of_a_rig_may_have_settings_of_its_own(toys):
    stereo = {
        "rig": {"use": "rig.stereo", "baseline_m": 0.1},
        "nodes": {
            "mean": {"use": "transform.toy-mean", "in": {"frames": "raw"}, "gain": 1.0},
            "level": {"use": "task.toy-level", "in": {"levels": "mean"}},
            "raw": {"use": "sensor.toy", "in": {"capture": "light"}},
        },
        "effects": [
            {"use": "effect.toy-offset", "name": "both"},
            {"use": "effect.toy-dim", "cameras": ["right"]},
        ],
    }
    design = {
        "design": {
            "effects.both.left.offset_dn": {"between": [0, 40]},
            "effects.toy-dim.share": {"between": [0, 1]},
            "raw.right.sigma_dn": {"between": [0, 2]},
        }
    }
    plain = {"effects.both.left.offset_dn": 0.0, "effects.toy-dim.share": 0.0, "raw.right.sigma_dn": 1.0}
    before = evaluated(toys, [stereo, design], **plain).scores
    left = evaluated(toys, [stereo, design], **{**plain, "effects.both.left.offset_dn": 30.0}).scores
    assert left["level.first"] == pytest.approx(before["level.first"] + 30, abs=5)
    assert left["level.last"] == before["level.last"]
    right = evaluated(toys, [stereo, design], **{**plain, "effects.toy-dim.share": 0.5}).scores
    assert right["level.last"] < 0.7 * before["level.last"]
    assert right["level.first"] == before["level.first"]
    quiet = evaluated(toys, [stereo, design], **{**plain, "raw.right.sigma_dn": 0.0}).scores
    assert quiet["level.last"] != before["level.last"]
    assert quiet["level.first"] == before["level.first"]


def test_a_picture_of_the_study_is_what_a_task_sees(toys):
    graph = make_plan(recipe(ISP), toys).graph
    assert graph.shown == "tone"
    assert make_plan(recipe(), toys).graph.shown == "raw"
    assert make_plan(recipe(BRANCHES), toys).graph.shown == "jpeg"  # of the first sensor by name


def test_a_transform_is_told_the_frames_of_an_episode_in_order(toys, monkeypatch):
    counts = []
    transform = toy_plugin.Mean.transform

    @functools.wraps(transform)
    def watched(self, frames, *, exposure, memory):
        made = transform(self, frames, exposure=exposure, memory=memory)
        counts.append((frames.episode.first_frame, memory["frames"]))
        return made

    monkeypatch.setattr(toy_plugin.Mean, "transform", watched)
    changes = {
        "nodes": {
            "mean": {"use": "transform.toy-mean", "in": {"frames": "raw"}, "gain": 1.0},
            "level": {"use": "task.toy-level", "in": {"levels": "mean"}},
        }
    }
    evaluated(toys, [changes])
    assert counts == [(0, 1), (1, 2)]
    counts.clear()
    evaluated(toys, [changes])
    assert counts == [(0, 1), (1, 2)]  # and remembers nothing of another episode
