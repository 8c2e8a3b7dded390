"""A defect of a component fails the candidate it shows with, and ends a study only where it keeps showing."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
import toy_plugin
from toy_study import LEARNER, comparable, run, toy_recipe

from tacos_framework.cli import run_main
from tacos_framework.errors import Fault, UserError
from tacos_framework.settings.yaml_writer import to_yaml
from tacos_framework.simulation import Evaluation, failed_by
from tacos_framework.study import DEFECT
from tacos_framework.study.failure_policy import FailuresInARow, KeepsFailing
from tacos_framework.values import Capture, Episode, Exposure, FrameBatch, Rig
from tacos_plugins.executors.local import LocalExecutor
from tacos_validation.harness import result_of

RAISED = "task.toy-width raised ZeroDivisionError: a defect of the toy"
STOPPED = f"stopped by a defect: 5 candidates in a row failed by the same defect, the last: {RAISED}"


def crashing(above_deg, **sections):
    return toy_recipe(nodes={"width": {"crash_above_deg": above_deg}}, **sections)


def candidates(folder):
    lines = (folder / "generations.jsonl").read_text().splitlines()
    return [candidate for line in lines for candidate in json.loads(line)["candidates"]]


@pytest.fixture(scope="module")
def one_crashed(toys, tmp_path_factory):
    """A study of which some candidates, and not those that follow each other, raise."""
    folder = tmp_path_factory.mktemp("crashed")
    return run(crashing(110), toys, folder), folder


def test_the_candidate_fails_and_the_study_goes_on(one_crashed):
    result, folder = one_crashed
    failed = [candidate for candidate in candidates(folder) if candidate["failed"]]
    assert failed
    assert all(f"{RAISED} (in node 'width')" == candidate["failed"] for candidate in failed)
    assert all(candidate["fitness"] is None for candidate in failed)
    assert result["stopped"] == "all 4 generations were evaluated"
    assert result["test"]["designed"]["fitness"] is not None


def test_the_log_has_the_traceback(one_crashed):
    _, folder = one_crashed
    log = (folder / "log.txt").read_text()
    assert 'raise ZeroDivisionError("a defect of the toy")' in log
    assert "while evaluating the candidate {'focal_length_mm': " in log


def test_a_fault_of_what_the_recipe_names_ends_a_study_at_the_first_candidate() -> None:
    wrong = failed_by(Evaluation(values={}), UserError(Fault("house.glb", "is cut short")))
    with pytest.raises(KeepsFailing, match=r"and no candidate: UserError: house\.glb: is cut short"):
        FailuresInARow().saw(wrong)
    FailuresInARow().saw(failed_by(Evaluation(values={}), ZeroDivisionError()))  # of this one candidate


@pytest.mark.parametrize("executor", ["process", "ray"])
def test_workers_do_not_change_what_fails(toys, tmp_path, one_crashed, executor):
    pytest.importorskip("ray") if executor == "ray" else None
    result, folder = one_crashed
    spread = {"use": f"executor.{executor}", "workers": 2}
    assert comparable(run(crashing(110, executor=spread), toys, tmp_path)) == comparable(result)
    assert candidates(tmp_path) == candidates(folder)
    assert 'raise ZeroDivisionError("a defect of the toy")' in (tmp_path / "log.txt").read_text()


def test_a_resumed_study_fails_the_same_candidates(toys, tmp_path, one_crashed, monkeypatch):
    result, _ = one_crashed
    monkeypatch.setattr(toy_plugin.WidthTask, "begun", 0)
    monkeypatch.setattr(toy_plugin.WidthTask, "interrupt_at", 14)
    assert run(crashing(110), toys, tmp_path)["stopped"] == "interrupted by the user"
    monkeypatch.setattr(toy_plugin.WidthTask, "interrupt_at", None)
    assert comparable(run(crashing(110), toys, tmp_path, resume=True)) == comparable(result)


def test_a_defect_at_the_beginning_of_an_episode_names_the_component_too(toys, tmp_path, monkeypatch):
    def begin(self, *, state) -> toy_plugin.WidthScorer:
        raise ZeroDivisionError("a defect of begin")

    monkeypatch.setattr(toy_plugin.WidthTask, "begin", begin)
    stopped = run(toy_recipe(), toys, tmp_path)["stopped"]
    assert "task.toy-width raised ZeroDivisionError: a defect of begin" in stopped


def test_a_study_inside_a_procedure_goes_on_once_its_defect_is_mended(toys, tmp_path, monkeypatch):
    recipe, executor = toy_recipe(), LocalExecutor(LocalExecutor.Config())
    keywords = {"plugins": toys, "executor": executor}
    with monkeypatch.context() as broken:
        broken.setattr(toy_plugin.WidthScorer, "scores", lambda self: 1 / 0)
        assert result_of(recipe, tmp_path, resume=False, **keywords)["stopped"].startswith(DEFECT)
    assert (
        result_of(recipe, tmp_path, resume=True, **keywords)["stopped"] == "all 4 generations were evaluated"
    )


def test_on_error_stop_ends_the_study_with_the_error_unchanged(toys, tmp_path):
    with pytest.raises(ZeroDivisionError, match="a defect of the toy") as caught:
        run(crashing(10, study={"on_error": "stop"}), toys, tmp_path)
    notes = "\n".join(caught.value.__notes__)
    assert "in task.toy-width, in node 'width'" in notes
    assert "focal_length_mm" in notes


def test_several_in_a_row_stop_the_study_and_nothing_is_lost(toys, tmp_path):
    result = run(crashing(10), toys, tmp_path)
    assert result["stopped"].startswith(STOPPED)
    assert json.loads((tmp_path / "result.json").read_text())["stopped"] == result["stopped"]
    assert [c["failed"] for c in candidates(tmp_path)] == [f"{RAISED} (in node 'width')"] * 5


def test_a_mended_study_goes_on_as_if_nothing_had_been_wrong(toys, tmp_path, monkeypatch):
    recipe = crashing(110, optimizer={"generations": 3})
    sound = toy_plugin.WidthScorer.update

    def broken(self, frames: FrameBatch) -> None:
        raise ZeroDivisionError("a defect of the toy")

    monkeypatch.setattr(toy_plugin.WidthTask, "begun", 0)
    monkeypatch.setattr(toy_plugin.WidthScorer, "update", broken)
    assert run(recipe, toys, tmp_path / "mended")["stopped"].startswith(STOPPED)
    monkeypatch.setattr(toy_plugin.WidthScorer, "update", sound)
    mended = run(recipe, toys, tmp_path / "mended", resume=True)
    assert comparable(mended) == comparable(run(recipe, toys, tmp_path / "sound"))
    assert candidates(tmp_path / "mended") == candidates(tmp_path / "sound")


def test_a_small_first_generation_is_enough(toys, tmp_path):
    result = run(crashing(10, optimizer={"population": 3, "keep": 1, "parents": 2}), toys, tmp_path)
    assert result["stopped"].startswith("stopped by a defect: 3 candidates in a row failed")


def test_weights_that_are_shared_pass_by_a_candidate_that_raises(toys, tmp_path):
    sections = {**LEARNER, "nodes": {**LEARNER["nodes"], "width": {"crash_above_deg": 110}}}
    result = run(toy_recipe(**sections), toys, tmp_path)
    assert result["stopped"] == "all 4 generations were evaluated"
    assert any(candidate["failed"] for candidate in candidates(tmp_path))


def test_the_command_ends_with_status_1_and_says_why(tmp_path, capsys, distribution):
    (tmp_path / "toy.yaml").write_text(to_yaml(crashing(10).as_data()))
    distribution("acme-toys", "from toy_plugin import tacos_components")
    assert run_main([str(tmp_path / "toy.yaml"), "--out", str(tmp_path / "out"), "--quiet"]) == 1
    assert "task.toy-width of acme-toys raised ZeroDivisionError" in capsys.readouterr().out


def test_light_that_is_not_finite_fails_the_candidate(toys, tmp_path, monkeypatch):
    sound = toy_plugin.ToyRenderer.capture

    def capture(self, episode: Episode, *, rig: Rig, exposure: Exposure) -> Capture:
        captured = sound(self, episode, rig=rig, exposure=exposure)
        (view,) = captured.views
        if view.camera.hfov_deg < 110:
            return captured
        return Capture(episode, (replace(view, luminance_cd_m2=view.luminance_cd_m2 * np.nan),))

    monkeypatch.setattr(toy_plugin.ToyRenderer, "capture", capture)
    result = run(toy_recipe(), toys, tmp_path)
    failed = {candidate["failed"] for candidate in candidates(tmp_path)}
    (said,) = failed - {None}
    assert said.startswith(
        "renderer.toy gives nan as light of camera 'camera' in 384 of 384 values, the first at frame 0, row 0"
    )
    assert result["test"]["designed"]["fitness"] is not None
