"""``tacos captures``: what the commands do, print and refuse."""

from __future__ import annotations

import json
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tacos_framework.cli import run_main, tacos_main
from tacos_framework.plugins import Plugins
from tacos_gap.captures import read_captures
from tacos_gap.captures.coverage import untold
from tacos_gap.hypotheses.candidates import candidates

RECIPE = """\
tacos: 1
name: small bench
seed: 3
use: procedure.simulate-captures
rig: {use: rig.monocular, focal_length_mm: 0.4, sensor: {name: s, width_px: 64, height_px: 48, pixel_um: 3}}
renderer: {use: renderer.analytic}
sensor: {use: sensor.affine-noise, black_level_dn: 16}
gain_db: 24
captures:
  - {id: dark, kind: dark, frames: 2}
  - {id: flat, kind: flat, scene: {use: scene.light-box}, level: 0.5, frames: 2}
"""


@pytest.fixture
def recipe(tmp_path):
    path = tmp_path / "small.yaml"
    path.write_text(RECIPE)
    return path


def test_simulated_captures_can_be_read_and_checked(recipe, tmp_path, capsys):
    (tmp_path / "effects.yaml").write_text("[{use: effect.exposure-error, scale: 1.3}]")
    out = tmp_path / "out"
    options = [
        "--out",
        str(out),
        "--with",
        str(tmp_path / "effects.yaml"),
        "--quiet",
        "--set",
        "captures.1.frames=3",
    ]
    assert tacos_main(["captures", "simulate", str(recipe), *options]) == 0
    assert "2 captures, 5 frames, effect.exposure-error" in capsys.readouterr().out
    dark, flat = read_captures(out).captures
    assert (flat.real_dn.mean() - 16) / (flat.expected_dn.mean() - 16) == pytest.approx(1.3, rel=0.01)
    assert dark.real_dn.mean() == pytest.approx(16, abs=0.1)
    assert json.loads((out / "result.json").read_text())["effects"] == [
        {"use": "effect.exposure-error", "scale": 1.3}
    ]
    assert tacos_main(["captures", "check", str(out)]) == 0
    printed = capsys.readouterr().out
    assert "2 captures by a sensor of 64 x 48, RGB, 16 to 255 DN" in printed
    assert "focal-length-error, lens-distortion: kind board: 3 or more views" in printed


def test_a_capture_s_own_recipe_is_rendered_by_the_check(recipe, tmp_path, capsys):
    out = tmp_path / "out"
    assert tacos_main(["captures", "simulate", str(recipe), "--out", str(out), "--quiet"]) == 0
    path = out / "captures.yaml"
    path.write_text(path.read_text().replace("simulated: 135.5", "scene: ../small.yaml"))
    capsys.readouterr()
    assert tacos_main(["captures", "check", str(out)]) == 0
    assert "135.5" in capsys.readouterr().out


STOPS_AT_THE_SECOND = """\
import sys, time
from tacos_framework.cli import tacos_main
from tacos_gap.simulation.bench import CaptureBench
take = CaptureBench.capture
def take_one(bench, shot):
    if shot.id != "dark":
        print("at the second", flush=True)
        time.sleep(60)
    return take(bench, shot)
CaptureBench.capture = take_one
sys.exit(tacos_main(sys.argv[1:]))
"""


def files_of_captures(folder: Path) -> dict[str, bytes]:
    images = (path for path in folder.rglob("*") if path.parent != folder and path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in (*images, folder / "captures.yaml")}


@pytest.mark.parametrize("ended_by", [signal.SIGKILL, signal.SIGINT])
def test_a_simulation_that_was_ended_says_what_goes_on_with_it(ended_by, recipe, tmp_path, capsys):
    asked, out = ["captures", "simulate", str(recipe), "--quiet", "--out"], tmp_path / "out put"
    command = [sys.executable, "-c", STOPS_AT_THE_SECOND, *asked, str(out)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, **pipes) as process:
        assert process.stdout.readline() == "at the second\n"
        process.send_signal(ended_by)
        _, said = process.communicate()
    if ended_by == signal.SIGINT:
        assert process.returncode == 130
        assert said == "Interrupted (the same command with --resume goes on).\n"
    first = out / "dark" / "000.png"
    taken_ns = first.stat().st_mtime_ns

    assert tacos_main([*asked, str(out)]) == 2
    assert "Go on with it by --resume" in capsys.readouterr().err
    assert tacos_main(["captures", "check", str(out)]) == 2
    (typed,) = re.findall("`tacos (captures simulate .*)`", capsys.readouterr().err)

    assert tacos_main([*shlex.split(typed), "--quiet"]) == 0
    assert "2 captures, 4 frames" in capsys.readouterr().out
    assert first.stat().st_mtime_ns == taken_ns
    assert tacos_main([*asked, str(tmp_path / "unbroken")]) == 0
    assert files_of_captures(out) == files_of_captures(tmp_path / "unbroken")
    assert not (out / "captures_begun.jsonl").exists()


def test_photographs_without_captures_yaml_are_to_be_imported(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    photos = tmp_path / "my photos"
    (photos / "monday").mkdir(parents=True)
    (photos / "monday" / "IMG_1.JPG").write_bytes(b"")
    import_them = "tacos captures import 'my photos' --out 'my photos_captures'"
    for asked in (
        ["captures", "check", "my photos"],
        ["captures", "guide", "--for", "my photos"],
    ):
        assert tacos_main(asked) == 2
        assert import_them in capsys.readouterr().err
    assert run_main(["diagnose", "--set", "captures=my photos", "--out", "out", "--quiet"]) == 2
    assert import_them in capsys.readouterr().err
    assert tacos_main(["captures", "check", "my photos/monday/IMG_1.JPG"]) == 2
    assert "this is a file" in capsys.readouterr().err
    (photos / "sorted").mkdir()
    (photos / "sorted" / "captures.yaml").write_text("")
    assert tacos_main(["captures", "check", "my photos"]) == 2
    assert f"Name one of: {Path('my photos/sorted')}" in capsys.readouterr().err


def test_a_recipe_that_photographs_nothing_is_refused(tmp_path, capsys):
    assert tacos_main(["captures", "simulate", "headset_quick", "--out", str(tmp_path / "out")]) == 2
    assert "does not say what to photograph" in capsys.readouterr().err


def test_a_broken_folder_ends_in_faults(tmp_path, capsys):
    (tmp_path / "captures.yaml").write_text("tacos_captures: 1\ncamera: {width_px: 8}\ncaptures: []\n")
    assert tacos_main(["captures", "check", str(tmp_path)]) == 2
    assert "'camera.height_px' is missing" in capsys.readouterr().err


@pytest.mark.gl
@pytest.mark.slow
def test_the_shipped_bench_leaves_no_effect_untold(tmp_path):
    out = tmp_path / "out"
    assert tacos_main(["captures", "simulate", "bench", "--out", str(out), "--quiet"]) == 0
    folder = read_captures(out)
    assert untold(folder.captures, candidates(Plugins.discover()).effects) == {}
