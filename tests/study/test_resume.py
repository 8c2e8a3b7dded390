"""Runs that were broken off go on as if they had not been."""

from __future__ import annotations

import json
import multiprocessing
import os
import signal
import time

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


@pytest.mark.parametrize("generations_before_death", [1, 3])
def test_a_killed_run_resumes_to_the_same_result(toys, tmp_path, generations_before_death):
    recipe = toy_recipe(optimizer={"generations": 6}, nodes={"world": {"frames": 200}}, study={"episodes": 4})
    whole = run(recipe, toys, tmp_path / "whole")
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
    unbroken = (tmp_path / "whole" / "generations.jsonl").read_text().splitlines()
    assert records == [_timeless(json.loads(line)) for line in unbroken]


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
    with pytest.raises(UserError, match="seed differ"):
        run(toy_recipe(seed=99), toys, tmp_path / "out", resume=True)
