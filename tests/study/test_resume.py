"""Runs that were broken off go on as if they had not been."""

from __future__ import annotations

import json
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import toy_plugin
from toy_study import LEARNER, comparable, run, toy_recipe

import tacos_framework
from tacos_framework.errors import UserError
from tacos_framework.plugins import Plugins


def test_ctrl_c_keeps_what_was_computed_and_resume_equals_the_unbroken_run(toys, tmp_path):
    whole = run(toy_recipe(**LEARNER), toys, tmp_path / "whole")
    recipe = toy_recipe(**LEARNER)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(toy_plugin.WidthTask, "begun", 0)
        patch.setattr(toy_plugin.WidthTask, "interrupt_at", 15)
        broken = run(recipe, toys, tmp_path / "broken")
    assert broken["stopped"] == "interrupted by the user"
    assert broken["best"] is not None
    assert broken["test"] == {}
    resumed = run(recipe, toys, tmp_path / "broken", resume=True)
    assert comparable(resumed) == comparable(whole)
    assert (tmp_path / "broken" / "generations.jsonl").read_text().count("\n") == 4


def _run_in_child(recipe, out):
    plugins = Plugins.discover()
    plugins.register(toy_plugin)
    tacos_framework.run(recipe, out=out, plugins=plugins, report=False)


LONG = {"optimizer": {"generations": 6}, "nodes": {"world": {"frames": 80}}, "study": {"episodes": 4}}
"""A study whose generations take long beside the time until it is seen that one has ended."""


@pytest.fixture(scope="module")
def unbroken(toys, tmp_path_factory):
    """The study of `LONG` when nothing happens to it: its result and its folder."""
    out = tmp_path_factory.mktemp("unbroken") / "whole"
    return run(toy_recipe(**LONG), toys, out), out


@pytest.mark.parametrize("generations_before_death", [1, 3])
def test_a_killed_run_resumes_to_the_same_result(unbroken, toys, tmp_path, generations_before_death):
    recipe = toy_recipe(**LONG)
    whole, folder = unbroken
    out = tmp_path / "killed"
    child = multiprocessing.get_context("spawn").Process(target=_run_in_child, args=(recipe, out))
    child.start()
    lines = out / "generations.jsonl"
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and child.is_alive():
        if lines.exists() and lines.read_text().count("\n") >= generations_before_death:
            break
        time.sleep(0.005)
    os.kill(child.pid, signal.SIGKILL)
    child.join()
    assert child.exitcode == -signal.SIGKILL
    assert not (out / "result.json").exists()
    resumed = run(recipe, toys, out, resume=True)
    assert comparable(resumed) == comparable(whole)
    records = [_timeless(json.loads(line)) for line in lines.read_text().splitlines()]
    of_whole = (folder / "generations.jsonl").read_text().splitlines()
    assert records == [_timeless(json.loads(line)) for line in of_whole]


def _dying(*arguments: object) -> None:
    """Run the script of dying studies, on one thread, so that its children can be forked."""
    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    tests = Path(__file__).parents[1]
    path = [str(tests), *filter(None, [os.environ.get("PYTHONPATH")])]
    script = Path(__file__).with_name("dying.py")
    done = subprocess.run(
        [sys.executable, script, *map(str, arguments)],
        env={**os.environ, **one_thread, "PYTHONPATH": os.pathsep.join(path)},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def _left_in(out: Path) -> dict[str, object]:
    """All that a run leaves, but for times and the machine."""
    files: dict[str, object] = {
        str(path.relative_to(out)): path.read_bytes()
        for folder in ("samples", "weights")
        for path in sorted((out / folder).iterdir())
    }
    files["result.json"] = comparable(json.loads((out / "result.json").read_text()))
    lines = (out / "generations.jsonl").read_text().splitlines()
    files["generations.jsonl"] = [_timeless(json.loads(line)) for line in lines]
    files["names"] = sorted(path.name for path in out.iterdir())
    return files


@pytest.mark.parametrize("stride", [20, pytest.param(1, marks=pytest.mark.slow)])
def test_a_run_that_dies_at_any_file_operation_resumes_to_the_same_result(tmp_path, stride):
    _dying("each", tmp_path, stride)
    whole = _left_in(tmp_path / "whole")
    died = [path for path in tmp_path.iterdir() if path.name.isdecimal()]
    assert len(died) > 60 / stride
    for out in died:
        assert _left_in(out) == whole, out.name


@pytest.mark.parametrize("seed", range(3))
def test_a_run_killed_again_and_again_at_random_moments_ends_with_the_same_result(tmp_path, seed):
    _dying("random", tmp_path, seed, 8)
    assert _left_in(tmp_path / "killed") == _left_in(tmp_path / "whole")


def _timeless(line):
    return {key: value for key, value in line.items() if key != "seconds"}


def test_a_folder_in_use_is_refused_with_what_to_do(toys, tmp_path):
    run(toy_recipe(), toys, tmp_path / "out")
    with pytest.raises(UserError, match="not empty") as caught:
        run(toy_recipe(), toys, tmp_path / "out")
    assert "--resume" in str(caught.value)


def test_resuming_another_recipe_or_nothing_is_refused(toys, tmp_path):
    with pytest.raises(UserError, match="no run to resume"):
        run(toy_recipe(), toys, tmp_path / "nothing", resume=True)
    run(toy_recipe(), toys, tmp_path / "out")
    with pytest.raises(UserError, match=r"another recipe: seed was 3, and is 99 now"):
        run(toy_recipe(seed=99), toys, tmp_path / "out", resume=True)


def test_every_changed_setting_of_a_resumed_run_is_named_with_both_values(toys, tmp_path):
    run(toy_recipe(), toys, tmp_path / "out")
    changed = {"seed": 99, "test": {"frames": 3}, "rig": {"binning": 2}}
    with pytest.raises(UserError) as caught:
        run(toy_recipe(**changed), toys, tmp_path / "out", resume=True)
    said = str(caught.value)
    assert "seed was 3, and is 99 now" in said
    assert "test.frames was 4, and is 3 now" in said
    assert "rig.binning was not given, and is 2 now" in said
