"""``tacos-run diagnose``: what it writes, for whatever was captured, and what it refuses."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from tacos_framework import ProcedureRecipe, UserError, run
from tacos_framework.cli import run_main
from tacos_framework.plugins import Plugins
from tacos_framework.testing import ProcedureConformance
from tacos_gap.attribution import ForwardSelection
from tacos_gap.captures import RealCapture
from tacos_gap.captures.writer import write_captures
from tacos_gap.hypotheses.candidates import candidates
from tacos_gap.procedures.diagnose import Diagnose
from tests.gap.taken import HEIGHT, WIDTH, board, capture, effect, patchwork, taken

KEYS = {
    "verdict",
    "gap",
    "where",
    "causes",
    "cause_set",
    "complete",
    "unknown",
    "detectable",
    "closed_forms",
    "nuisances",
    "next_capture",
    "below_floor",
    "negative_control",
    "task",
    "limitations",
}


def diagnosed(
    captures: list[RealCapture], consider: set[str], plugins: Plugins, folder: Path, **settings: Any
) -> tuple[dict[str, Any], str]:
    """``diagnosis.json`` and the report of a folder with these captures, considering a few effects only."""
    write_captures(folder / "captures", captures)
    without = sorted(set(candidates(plugins).effects) - consider)
    recipe = ProcedureRecipe(
        "procedure.diagnose",
        {"captures": str(folder / "captures"), "without": without, "workers": 1, **settings},
    )
    run(recipe, out=folder / "out", plugins=plugins)
    data = json.loads((folder / "out" / "diagnosis.json").read_text("utf-8"))
    return data, (folder / "out" / "report.html").read_text("utf-8")


def test_a_run_that_is_stopped_leaves_what_is_known_and_goes_on(
    plugins: Plugins, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    captures = [capture("dark", 0.0), capture("flat", 60.0), capture("flat", 150.0)]
    write_captures(tmp_path / "captures", taken(captures, [effect(plugins, "vignetting", k1=-0.3)]))
    considered = {"vignetting", "read-noise", "black-level"}
    without = sorted(set(candidates(plugins).effects) - considered)
    settings = {"captures": str(tmp_path / "captures"), "without": without, "workers": 1}
    recipe = ProcedureRecipe("procedure.diagnose", settings)

    def stop(*_: Any) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(ForwardSelection, "_rivals", stop)
        with pytest.raises(KeyboardInterrupt):
            run(recipe, out=tmp_path / "out", plugins=plugins)
    so_far = json.loads((tmp_path / "out" / "so_far.json").read_text("utf-8"))
    says = {form["effect"]: form["says"] for form in so_far["closed_forms"] if form["parameter"] != "k2"}
    assert says == {"vignetting": "seen", "black-level": "excluded"}
    assert [term["effect"] for term in so_far["explanation"]] == ["vignetting"]
    told = run(recipe, out=tmp_path / "out", plugins=plugins, resume=True)
    assert [cause["effect"] for cause in told["diagnosis"]["causes"]] == ["vignetting"]


def headline(report: str) -> str:
    found = re.search(r"<h1>(.*?)</h1>", report, re.DOTALL)
    assert found is not None
    return " ".join(found[1].split())


def test_vignetting_is_found_drawn_and_patched(plugins: Plugins, tmp_path: Path) -> None:
    captures = [capture("dark", 0.0), capture("flat", 60.0), capture("flat", 150.0)]
    captures = taken(captures, [effect(plugins, "vignetting", k1=-0.3)])
    data, report = diagnosed(captures, {"vignetting", "exposure-error", "read-noise"}, plugins, tmp_path)
    assert set(data) >= KEYS
    assert data["verdict"] == "explained"
    assert [cause["effect"] for cause in data["causes"]] == ["vignetting"]
    cause = data["causes"][0]
    assert cause["closure"]["held_out"] is True
    assert cause["closure"]["value"] > 0.9
    assert set(cause["parameters"]) >= {"k1"}
    assert data["gap"]["before"] > 5 > data["gap"]["after"]
    assert data["task"] == {}  # even fields have no features
    assert headline(report).startswith("Vignetting explains the gap")
    assert "http" not in report.replace("http-equiv", "")
    assert report.count("<svg") >= 5
    log = (tmp_path / "out" / "log.txt").read_text("utf-8")
    for stage in ("measuring the captures", "trying effects", "vignetting", "comparing with rivals"):
        assert f"{stage} (" in log, "where it is can be read while it runs"
    patch = tmp_path / "out" / "patched.yaml"
    assert [entry["use"] for entry in yaml.safe_load(patch.read_text("utf-8"))] == ["effect.vignetting"]
    assert run_main(["headset_quick", "--with", str(patch), "--check"]) == 0


def test_what_tells_nothing_gets_an_answer_with_every_key(plugins: Plugins, tmp_path: Path) -> None:
    (flat,) = taken([capture("flat", 100.0)], [])
    told, _ = diagnosed([flat], {"read-noise"}, plugins, tmp_path / "told")
    nowhere = np.zeros((HEIGHT, WIDTH), bool)
    data, report = diagnosed([replace(flat, valid=nowhere)], {"read-noise"}, plugins, tmp_path / "untold")
    for one, other in ((told, data), *((told[k], data[k]) for k in ("gap", "complete", "unknown"))):
        assert set(one) == set(other)
    assert (data["verdict"], data["causes"], data["cause_set"]) == ("unknown", [], [])
    assert data["complete"]["score"] == 0
    assert data["next_capture"]["kind"] == "flat"
    assert any("its mask leaves no pixel" in text for text in data["limitations"])
    assert headline(report) == "Nothing could be measured in these captures"
    assert "its mask leaves no pixel" in report
    assert yaml.safe_load((tmp_path / "untold" / "out" / "patched.yaml").read_text("utf-8")) == []


def test_task_scores_of_the_patched_simulation_are_nearer_to_the_real_ones(
    plugins: Plugins, tmp_path: Path
) -> None:
    captures = taken(
        [capture("scene", patchwork(), frames=3), capture("flat", 100.0)],
        [effect(plugins, "defocus", radius_px=1.6)],
    )
    data, report = diagnosed(captures, {"defocus", "read-noise"}, plugins, tmp_path)
    assert [cause["effect"] for cause in data["causes"]] == ["defocus"]
    radius = data["causes"][0]["parameters"]["radius_px"]
    assert radius["unit"] == "px"
    assert radius["physical"]["name"] == "radius_um"
    assert radius["physical"]["value"] == pytest.approx(12 * radius["value"], rel=1e-3), "pixels of 12 um"
    assert radius["physical"]["ci"] == pytest.approx([12 * end for end in radius["ci"]], rel=0.01)
    patch = yaml.safe_load((tmp_path / "out" / "patched.yaml").read_text("utf-8"))
    assert patch == [{"use": "effect.defocus", "radius_um": radius["physical"]["value"]}]
    assert "radius_um" in report
    assert "radius_px" in report
    inliers = data["task"]["features.inliers"]
    assert set(inliers) == {"real", "sim_before", "sim_after", "ci", "captures"}
    assert abs(inliers["sim_after"] - inliers["real"]) < abs(inliers["sim_before"] - inliers["real"])
    assert "Consequences for tasks" in report
    assert "Contrast of detail over spatial frequency" in report


def test_exposure_that_settles_over_a_sequence_is_found(plugins: Plugins, tmp_path: Path) -> None:
    steady = [capture("dark", 0.0), capture("flat", 90.0), capture("sequence", patchwork(), frames=6)]
    real = taken(steady, [effect(plugins, "auto-exposure", first=0.7, lag_frames=1.5)])
    real[1] = taken([steady[1]], [])[0]  # a flat is taken once all has settled
    data, _ = diagnosed(real, {"auto-exposure", "read-noise"}, plugins, tmp_path)
    assert [cause["effect"] for cause in data["causes"]] == ["auto-exposure"]
    assert data["causes"][0]["parameters"]["first"]["value"] < 0.9


def test_no_gap_is_said_and_nothing_patched(plugins: Plugins, tmp_path: Path) -> None:
    captures = taken([capture("dark", 0.0), capture("flat", 80.0)], [])
    data, report = diagnosed(captures, {"vignetting", "read-noise"}, plugins, tmp_path)
    assert data["verdict"] == "no_gap"
    assert headline(report).startswith("No gap")
    assert yaml.safe_load((tmp_path / "out" / "patched.yaml").read_text("utf-8")) == []
    assert "<h2>Causes" not in report


def test_darks_alone_make_a_report(plugins: Plugins, tmp_path: Path) -> None:
    captures = taken([capture("dark", 0.0)], [effect(plugins, "read-noise", sigma_dn=2.0)])
    data, report = diagnosed(captures, {"read-noise", "black-level"}, plugins, tmp_path)
    assert [cause["effect"] for cause in data["causes"]] == ["read-noise"]
    assert "Noise against signal" in report


def test_boards_alone_make_a_report_with_the_corners_misfit(plugins: Plugins, tmp_path: Path) -> None:
    captures = [board(turn, barrel=0.8) for turn in (-30.0, -12.0, 10.0, 30.0)]
    data, report = diagnosed(captures, {"lens-distortion", "focal-length-error"}, plugins, tmp_path)
    assert data["where"][0]["statistic"] == "board_corners"
    assert "Corners of the boards" in report
    assert data["causes"][0]["effect"] == "lens-distortion"


def test_colour_from_one_scene_in_a_single_frame_makes_a_report(plugins: Plugins, tmp_path: Path) -> None:
    scene = capture("scene", patchwork(), frames=1, channels=3)
    captures = taken([scene], [effect(plugins, "white-balance", red=1.15, blue=0.85)])
    data, report = diagnosed(captures, {"white-balance", "defocus"}, plugins, tmp_path)
    assert data["causes"][0]["effect"] == "white-balance"
    assert data["task"] == {}  # a single frame has nothing to be matched with
    assert "Real and simulated" in report


def test_a_folder_that_is_not_there_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    missing = tmp_path / "missing"
    status = run_main(["diagnose", "--set", f"captures={missing}", "--out", str(tmp_path / "out"), "--quiet"])
    assert status == 2
    assert f"{missing}: there is no such folder" in capsys.readouterr().err


def test_an_empty_folder_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    empty = tmp_path / "empty"
    empty.mkdir()
    status = run_main(["diagnose", "--set", f"captures={empty}", "--out", str(tmp_path / "out"), "--quiet"])
    assert status == 2
    assert "there is no captures.yaml" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"without": ["vigneting"]}, "no effect is called vigneting"),
        ({"study": "headset_quik"}, "there is no such recipe"),
        ({"study": "diagnose"}, "diagnose is no study"),
        ({"study": "headset_quick", "change": {"compare.cameras": ["flea9"]}}, "flea9"),
        ({"task": "bench"}, "bench is no study"),
    ],
)
def test_wrong_settings_are_refused_before_any_work(
    settings: dict[str, Any], said: str, plugins: Plugins, tmp_path: Path
) -> None:
    recipe = ProcedureRecipe("procedure.diagnose", {"captures": str(tmp_path / "none"), **settings})
    with pytest.raises(UserError, match=said):
        run(recipe, out=tmp_path / "out", plugins=plugins)


def test_all_that_is_wrong_is_said_as_the_recipe_is_checked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "captures.yaml").write_text("tacos_captures: 1\ncamera: {width_px: 0}\ncaptures: []\n")
    sets = [f"captures={tmp_path}", "without=[vigneting]", "study=headset_quik", "task=bench"]
    status = run_main(["diagnose", "--check", *(word for each in sets for word in ("--set", each))])
    assert status == 2
    said = capsys.readouterr().err
    for part in ("captures.yaml:2", "vigneting", "headset_quik", "bench is no study"):
        assert part in said
    assert "Traceback" not in said


class TestDiagnose(ProcedureConformance):
    """Equal seeds find the same, whatever the threads do."""

    component = Diagnose
    files = ("diagnosis.json", "patched.yaml", "report.html")

    @pytest.fixture(autouse=True)
    def _captures(self, plugins: Plugins, tmp_path_factory: pytest.TempPathFactory) -> None:
        folder = tmp_path_factory.mktemp("prnu")
        shown = taken([capture("dark", 0.0), capture("flat", 120.0)], [effect(plugins, "prnu", sigma=0.02)])
        write_captures(folder, shown)
        without = set(candidates(plugins).effects) - {"prnu", "read-noise", "vignetting"}
        self.config = {"captures": str(folder), "without": tuple(sorted(without))}  # type: ignore[misc]
