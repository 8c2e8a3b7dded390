"""Scores of tasks on captures: which can be scored, and how sure they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tacos_framework.plan import ConfiguredComponent
from tacos_framework.plugins import Plugins
from tacos_gap.captures import Objects, read_captures, write_captures
from tacos_gap.tasks import (
    CaptureScores,
    RecipeTask,
    ScoredTasks,
    default_tasks,
    score_tasks,
    task_gap,
    tasks_of,
)
from tacos_gap.tasks.captured_frames import TruthMissing, as_batch
from tacos_gap.tasks.recipe_tasks import frozen_plan
from tests.gap.taken import capture, effect, patchwork, taken


def task_of(plugins: Plugins, name: str, **settings: object) -> RecipeTask:
    cls = plugins.resolve(f"task.{name}", "task")
    return RecipeTask(name, ConfiguredComponent(f"task.{name}", cls, cls.Config(**settings)))


def test_blur_loses_features_in_reality_and_with_its_cause(plugins: Plugins) -> None:
    blur = effect(plugins, "defocus", radius_px=2.2)
    shown = taken([capture("scene", patchwork(), frames=6), capture("flat", 90.0)], [blur])
    gap = task_gap(score_tasks(shown, lambda _: [blur], default_tasks(plugins), seed=1))
    inliers = gap["features.inliers"]
    assert inliers.captures == 1, "an even field shows nothing"
    assert inliers.intervals is not None
    low, high = inliers.intervals["real"]
    assert low < inliers.sim_after < high
    assert not low < inliers.sim_before < high
    assert set(inliers.as_data()) == {"real", "sim_before", "sim_after", "ci", "captures"}


def test_every_task_of_a_study_is_scored_or_named_with_the_reason(plugins: Plugins) -> None:
    tasks = tasks_of(frozen_plan("headset_quick", {}, plugins))
    assert {task.node for task in tasks} == {"features", "obstacle"}
    shown = taken([capture("scene", patchwork(), frames=4)], [])
    scored = score_tasks(shown, lambda _: [], tasks, seed=1)
    assert any(name.startswith("features.") for name in scored.names)
    (said,) = scored.left_out
    assert "obstacle (task.obstacle-visibility)" in said
    assert "which object each pixel shows" in said or "no score" in said


def test_stereo_needs_two_cameras(plugins: Plugins) -> None:
    shown = taken([capture("scene", patchwork(), frames=4)], [])
    scored = score_tasks(shown, lambda _: [], [task_of(plugins, "sgbm")], seed=1)
    assert not scored.names
    assert "single camera" in scored.left_out[0]


def test_no_scene_no_score(plugins: Plugins) -> None:
    scored = score_tasks(taken([capture("flat", 90.0)], []), lambda _: [], default_tasks(plugins), seed=1)
    assert task_gap(scored) == {}
    assert "no capture is of a scene" in scored.left_out[0]


def test_what_nobody_knows_is_refused_and_what_is_known_is_given() -> None:
    scene = taken([capture("scene", patchwork())], [])[0]
    view = as_batch(scene, scene.real_dn).capture.views[0]
    with pytest.raises(TruthMissing, match="depth"):
        _ = view.depth_m
    ids = np.zeros(scene.valid.shape, np.int32)
    ids[10:20, 10:20] = 1
    depth_m = np.full(scene.valid.shape, 2.0)
    known = replace(
        scene,
        objects=Objects(ids, ("background", "chair")),
        context=replace(scene.context, depth_m=depth_m),
    )
    batch = as_batch(known, known.real_dn)
    assert (batch.capture.views[0].depth_m == 2.0).all()
    assert batch.episode.world.objects[int(batch.capture.views[0].object_id.max())].class_name == "chair"


def test_labelled_objects_survive_the_folder(tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("labelled")
    scene = taken([capture("scene", patchwork())], [])[0]
    ids = np.arange(scene.valid.size, dtype=np.int32).reshape(scene.valid.shape) % 3
    write_captures(folder, [replace(scene, objects=Objects(ids, ("background", "chair", "table")))])
    again = read_captures(folder).captures[0].objects
    assert again is not None
    assert again.classes == ("background", "chair", "table")
    assert (again.ids == ids).all()


def test_intervals_hold_the_mean_of_the_noise_in_nine_of_ten_cases() -> None:
    """Coverage of the interval, with Gaussian scores whose true mean is 50."""
    rng = np.random.default_rng(8)

    def drawn(count: int) -> tuple[dict[str, float], ...]:
        return tuple({"t.s": float(v)} for v in rng.normal(50, 4, count))

    held = []
    for _ in range(400):
        captures = tuple(CaptureScores(str(i), drawn(2), drawn(4), drawn(4)) for i in range(2))
        found = task_gap(ScoredTasks(captures, ()))["t.s"]
        assert found.intervals is not None
        held.append([low < 50 < high for low, high in found.intervals.values()])
    assert np.mean(held, axis=0) == pytest.approx([0.93, 0.9, 0.9], abs=0.05)


def test_a_score_in_one_draw_alone_has_no_interval() -> None:
    one = ({"t.s": 3.0},)
    found = task_gap(ScoredTasks((CaptureScores("a", one, one, one),), ()))["t.s"]
    assert found.intervals is None
    assert found.as_data()["ci"] is None
