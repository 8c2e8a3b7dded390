"""What a user of the two commands types and sees."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tacos_framework import __version__
from tacos_framework.cli import run_main, tacos_main

SMALL = """\
tacos: 1
name: small
seed: 7
rig: {use: rig.monocular, binning: 24}
design:
  focal_length_mm: {between: [2, 8]}
  sensor: {from: image_sensors, scheme: discrete}
nodes:
  world: {use: scene.indoor, frames: 2, size_m: [11, 6]}
  capture: {use: renderer.moderngl, in: {episode: world}, light_texel_m: 0.3}
  frames: {use: sensor.affine-noise, in: {capture: capture}}
  features: {use: task.orb-features, in: {frames: frames}}
fitness: [{score: features.inliers, weight: 1}]
optimizer: {use: optimizer.random, evaluations: 2}
test: {seed: 1001}
"""


@pytest.fixture
def recipe(tmp_path: Path) -> Path:
    path = tmp_path / "small.yaml"
    path.write_text(SMALL)
    return path


def command(*arguments: str, **options: object) -> subprocess.Popen[str]:
    code = "import sys; from tacos_framework.cli import run_main; sys.exit(run_main())"
    return subprocess.Popen(
        [sys.executable, "-c", code, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,  # type: ignore[call-overload]
    )


def test_a_recipe_runs_to_a_result_and_a_report(recipe, tmp_path, capsys):
    out = tmp_path / "out"
    assert run_main([str(recipe), "--out", str(out), "--set", "optimizer.evaluations=3"]) == 0
    printed = capsys.readouterr()
    assert "Designing: 3 to do" in printed.err
    assert f"Report: {out / 'report.html'}" in printed.out
    result = json.loads((out / "result.json").read_text())
    assert (
        result["evaluations"] == 3 + 3 + 1
    )  # searched, scored again on the test scenes, and the design itself
    assert result["command"].startswith("tacos-run ")
    assert "OpenGL" in result["environment"]["findings"]
    assert "--set optimizer.evaluations=3" in result["command"]
    report = (out / "report.html").read_text()
    assert result["best"]["camera"]["sensor"]["name"] in report
    assert 'src="data:image/' in report
    assert tacos_main(["report", str(out)]) == 0


def test_check_and_explain_stop_before_any_work(recipe, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run_main([str(recipe), "--check"]) == 0
    assert "no faults" in capsys.readouterr().out
    assert run_main([str(recipe), "--explain", "--with", str(_effects(tmp_path))]) == 0
    explained = capsys.readouterr().out
    assert "optics: effect.vignetting" in explained
    assert (
        "sensor: one of 43 parts of image_sensors, discrete; reaches capture, frames, features" in explained
    )
    assert not (tmp_path / "runs").exists()


def _effects(folder: Path) -> Path:
    path = folder / "patched.yaml"
    path.write_text("- {use: effect.vignetting, k1: -0.4}\n")
    return path


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["headset_quik"], "Did you mean 'headset_quick'?"),
        (["not_there.yaml"], "not_there.yaml"),
        (["not_there/mine.yaml"], "there is no folder 'not_there' either"),
        (["runs/not_there"], "Check the path."),
        (["headset_quick", "--set", "optimizer.evaluations"], "there is no '='"),
        (["headset_quick", "--set", "optimiser.generations=3"], "Did you mean 'optimizer'?"),
        (
            ["headset_quick", "--set", "optimizer.evaluations=many"],
            '--set optimizer.evaluations: evaluations is "many"',
        ),
        (["headset_quick", "--set", "seed=.nan"], "seed"),
        (["headset_quick", "--executor", "executor.cloud"], "executor.cloud"),
        (["headset_quick", "--workers", "0"], "greater than or equal to 1"),
        (["headset_quick", "--resume"], "Name its folder with --out"),
        (["headset_quick", "--with", "not_there.yaml"], "not_there.yaml"),
    ],
)
def test_wrong_input_ends_with_status_2_and_no_traceback(arguments, message, capsys):
    assert run_main([*arguments, "--check"]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert "Traceback" not in error


def test_all_faults_of_all_files_of_effects_come_with_those_of_the_recipe(tmp_path, capsys):
    (tmp_path / "unknown.yaml").write_text(
        "effects:\n  - use: effect.vignetting\n    strenght: 2\n"
        "others:\n  - use: effect.jpeg\n    strenght: 3\n"
    )
    (tmp_path / "none.yaml").write_text("k1: 3\n")
    (tmp_path / "broken.yaml").write_text("[{use: effect.jpeg\n")
    files = [str(tmp_path / name) for name in ("unknown.yaml", "none.yaml", "broken.yaml", "not_there.yaml")]
    options = [word for file in files for word in ("--with", file)]
    assert run_main(["headset_quick", *options, "--set", "seed=-1", "--check"]) == 2
    error = capsys.readouterr().err
    assert "5 faults" in error
    assert f"{files[0]}:3:5: unknown key 'strenght'" in error
    assert f"{files[1]}:1:1: no list of effects" in error
    assert f"{files[2]}:2:1: this is not valid YAML" in error
    assert f"{files[3]}: there is no file" in error
    assert "--set seed: seed is -1" in error


@pytest.mark.parametrize("given", [["--captures", "mine"], ["--captures=mine"]])
def test_a_setting_given_as_an_option_is_told_how_it_is_given(given, capsys):
    with pytest.raises(SystemExit) as ended:
        run_main(["diagnose", *given])
    assert ended.value.code == 2
    assert "try --set captures=mine" in capsys.readouterr().err


def test_effects_for_a_procedure_that_takes_none_are_refused(tmp_path, capsys):
    (tmp_path / "effects.yaml").write_text("[{use: effect.vignetting, k1: -0.3}]")
    assert run_main(["diagnose", "--with", str(tmp_path / "effects.yaml"), "--check"]) == 2
    assert "this procedure takes no effects" in capsys.readouterr().err


def test_a_list_is_asked_for_in_the_words_of_yaml(capsys):
    assert run_main(["diagnose", "--set", "without=vignetting", "--check"]) == 2
    assert "expected: a list, as in [a, b]" in capsys.readouterr().err


def test_results_that_cannot_be_written_are_refused_before_any_work(recipe, tmp_path, capsys):
    (tmp_path / "file").write_text("in the way")
    assert run_main([str(recipe), "--out", str(tmp_path / "file")]) == 2
    assert "this is a file" in capsys.readouterr().err
    assert run_main([str(recipe), "--out", str(tmp_path / "file" / "out")]) == 2
    assert "cannot be written" in capsys.readouterr().err


@pytest.mark.parametrize("ended_by", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_and_sigterm_keep_what_was_computed(recipe, tmp_path, ended_by):
    out = tmp_path / "out"
    sets = ["--set", "optimizer.evaluations=100000", "--set", "study.renew_episodes=never"]
    running = command(
        str(recipe), "--out", str(out), *sets, "--set", "optimizer.batch=2", start_new_session=True
    )
    deadline = time.monotonic() + 120
    lines = out / "generations.jsonl"
    while time.monotonic() < deadline and running.poll() is None:
        if lines.exists() and lines.read_text().count("\n") >= 2:
            break
        time.sleep(0.05)
    os.killpg(running.pid, ended_by)
    _, errors = running.communicate(timeout=60)
    assert running.returncode == 130, errors
    assert "Traceback" not in errors
    result = json.loads((out / "result.json").read_text())
    assert result["stopped"] == "interrupted by the user"
    assert result["best"]["fitness"] is not None
    assert (out / "report.html").exists()


def test_plugins_doctor_and_catalogs_speak(capsys):
    assert tacos_main(["plugins"]) == 0
    assert "renderer.moderngl" in capsys.readouterr().out
    assert tacos_main(["doctor"]) == 0
    assert "ok   OpenGL: " in capsys.readouterr().out
    assert tacos_main(["catalog"]) == 0
    listed = capsys.readouterr().out
    assert "image_sensors " in listed
    assert "cameras " in listed
    assert tacos_main(["catalog", "image_sensors"]) == 0
    shown = capsys.readouterr().out
    assert "MT9V022*" in shown
    assert "* MT9V022: " in shown
    assert tacos_main(["catalog", "cameras"]) == 0
    assert "focal_length_mm: 2.75" in capsys.readouterr().out
    assert tacos_main(["catalog", "lenses"]) == 0
    assert "7.18~" in capsys.readouterr().out  # derived
    assert tacos_main(["catalog", "mirrors"]) == 2
    assert tacos_main(["report", "nowhere"]) == 2


def test_both_commands_say_their_version_and_help(capsys: pytest.CaptureFixture[str]) -> None:
    for command in (tacos_main, run_main):
        with pytest.raises(SystemExit) as ended:
            command(["--version"])
        assert ended.value.code == 0
        assert capsys.readouterr().out == f"tacos-framework {__version__}\n"
    assert tacos_main([]) == 0
    assert "Recipes are run by tacos-run" in capsys.readouterr().out
    assert run_main([]) == 0
    assert "--extend KEY=N" in capsys.readouterr().out


def test_tacos_run_names_the_command_that_was_meant(capsys: pytest.CaptureFixture[str]) -> None:
    assert tacos_main(["run", "my recipe.yaml", "--seed", "1"]) == 2
    assert "tacos-run 'my recipe.yaml' --seed 1" in capsys.readouterr().err
    assert tacos_main(["headset_quick", "--check"]) == 2
    assert "Try: tacos-run headset_quick --check" in capsys.readouterr().err
    assert tacos_main(["viw"]) == 2
    assert "Did you mean 'view'?" in capsys.readouterr().err


def test_a_folder_in_the_place_of_a_recipe_is_told_apart(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "run").mkdir()
    assert run_main([str(tmp_path / "run")]) == 2
    assert "no run is in it" in capsys.readouterr().err
    (tmp_path / "run" / "recipe.yaml").write_text("{}")
    assert run_main([str(tmp_path / "run")]) == 2
    assert f"tacos-run --resume {tmp_path / 'run'}" in capsys.readouterr().err
    assert run_main(["run9"]) == 2
    told = capsys.readouterr().err
    assert "no folder of a run" in told
    assert "`tacos recipes` lists" in told


def test_check_opens_the_world_of_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    corners = [f"v {800 * x} {600 * y} {280 * z}" for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    quads = ["f 1 2 4 3", "f 5 7 8 6", "f 1 5 6 2", "f 3 4 8 7", "f 1 3 7 5", "f 2 6 8 4"]
    (tmp_path / "hall.obj").write_text("\n".join([*corners, *quads]) + "\n")
    world = f"nodes.world={{use: scene.imported, frames: 6, file: {tmp_path / 'hall.obj'}}}"
    assert run_main(["stereo_quick", "--check", "--set", world]) == 0
    assert "is the file in centimetres: metres_per_unit 0.01?" in capsys.readouterr().out
    (tmp_path / "hall.obj").write_text("v 0 0 nothing\nf 1 1 1\n")
    assert run_main(["stereo_quick", "--check", "--set", world]) == 2
    assert "hall.obj" in capsys.readouterr().err
