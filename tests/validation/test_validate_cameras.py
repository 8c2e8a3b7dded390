"""``tacos-run validate_cameras``: whether a simulator ranks real cameras as reality does."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tacos_framework import ProcedureRecipe, UserError, run
from tacos_framework.cli import run_main
from tacos_framework.plugins import Plugins
from tacos_gap.captures import write_captures
from tacos_gap.tasks import CaptureScores
from tacos_validation.cameras_validated.ranking import agreement_with_reality, camera_scores
from tests.gap.taken import capture, effect, patchwork, taken


@pytest.fixture(scope="module")
def cameras(plugins: Plugins, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three cameras that a simulator without effects takes for one, each with the patch of what it has."""
    folder = tmp_path_factory.mktemp("cameras")
    real = {
        "sharp": [],
        "soft": [("defocus", {"radius_px": 1.3})],
        "softer": [("defocus", {"radius_px": 2.2})],
    }
    for i, (name, effects) in enumerate(real.items()):
        shown = [
            capture("dark", 0.0),
            *(capture("flat", level) for level in (40.0, 100.0, 170.0)),
            capture("scene", patchwork(), frames=6),
        ]
        have = [effect(plugins, of, **settings) for of, settings in effects]
        write_captures(folder / name, taken(shown, have, seed=i))
        lines = [f"- {{use: effect.{of}, radius_px: {s['radius_px']}}}" for of, s in effects]
        (folder / name / "patched.yaml").write_text("\n".join(lines) or "[]", "utf-8")
    return folder


def test_the_patched_simulator_ranks_cameras_as_reality_does(
    cameras: Path, plugins: Plugins, tmp_path: Path
) -> None:
    recipe = ProcedureRecipe("procedure.validate-cameras", {"captures": str(cameras), "patches": "given"})
    result = run(recipe, out=tmp_path / "out", plugins=plugins)
    found = result["tasks"]["features.inliers"]
    assert found["order"]["real"] == found["order"]["sim_after"] == ["sharp", "soft", "softer"]
    assert found["agreement"]["sim_after"]["tau"] == 1.0
    assert found["agreement"]["sim_before"]["tau"] < 1.0
    low, high = found["agreement"]["sim_after"]["ci"]
    assert -1 <= low <= 1.0 == high
    for camera, levels in found["levels"].items():
        if camera != "sharp":
            assert not levels["sim_before"]["low"] < levels["real"]["mean"] < levels["sim_before"]["high"]
    assert result["noise"]["sharp"]["real"]["photon_dn"] == pytest.approx(0.24, rel=0.05)
    assert result["noise"]["sharp"]["off"]["sim_after"] < 0.1
    assert (tmp_path / "out" / "cameras" / "soft" / "patched.yaml").read_text().startswith("- {use")
    report = (tmp_path / "out" / "report.html").read_text("utf-8")
    assert "once the causes are simulated" in report
    assert report.count("<svg") >= 3
    json.dumps(result, allow_nan=False)


@pytest.mark.slow
def test_cameras_are_diagnosed_where_no_patch_is_given(
    cameras: Path, plugins: Plugins, tmp_path: Path
) -> None:
    recipe = ProcedureRecipe("procedure.validate-cameras", {"captures": str(cameras), "workers": 1})
    result = run(recipe, out=tmp_path / "out", plugins=plugins)
    assert result["cameras"]["sharp"] == {"verdict": "no_gap", "causes": []}
    assert result["tasks"]["features.inliers"]["agreement"]["sim_after"]["tau"] == 1.0
    assert (tmp_path / "out" / "cameras" / "softer" / "diagnosis.json").is_file()


def test_one_camera_cannot_be_ranked(cameras: Path, tmp_path: Path) -> None:
    alone = tmp_path / "alone"
    (alone / "only").mkdir(parents=True)
    (alone / "only" / "captures.yaml").write_text((cameras / "sharp" / "captures.yaml").read_text())
    with pytest.raises(UserError, match="one cannot be ranked"):
        run(
            ProcedureRecipe("procedure.validate-cameras", {"captures": str(alone)}),
            out=tmp_path / "out",
            plugins=Plugins.discover(),
        )


def test_all_faults_are_said_at_once(
    cameras: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sets = [f"captures={tmp_path / 'none'}", "study=headset_quik", "without=[vigneting]"]
    status = run_main(["validate_cameras", "--check", *(word for each in sets for word in ("--set", each))])
    said = capsys.readouterr().err
    assert status == 2
    assert all(part in said for part in ("no such folder", "headset_quik", "vigneting"))


def scores_of(values: dict[str, list[float]], spread: float = 0.0) -> dict[str, list[CaptureScores]]:
    """Cameras with a real score per scene, simulated alike before and reversed after."""

    def several(value: float) -> tuple[dict[str, float], ...]:
        return tuple({"t.s": value + step * spread} for step in (-1, 1))

    return {
        camera: [
            CaptureScores(f"scene_{i}", several(v), several(v), several(-v)) for i, v in enumerate(found)
        ]
        for camera, found in values.items()
    }


@pytest.mark.parametrize(("lower_is_better", "best"), [(False, "c"), (True, "a")])
def test_rankings_agree_or_oppose(lower_is_better: bool, best: str) -> None:
    found: Any = camera_scores(
        "t.s",
        scores_of({"a": [1.0, 2.0], "b": [2.0, 3.0], "c": [3.0, 4.0]}),
        lower_is_better=lower_is_better,
    )
    assert found.order("real")[0] == best
    assert agreement_with_reality(found, "sim_before", 1).tau == pytest.approx(1)
    assert agreement_with_reality(found, "sim_after", 1).agreement.tau.high == pytest.approx(-1)


def test_noise_widens_the_interval_of_a_rank_correlation() -> None:
    values = {"a": [1.0], "b": [1.1], "c": [1.2]}
    sure: Any = camera_scores("t.s", scores_of(values))
    unsure: Any = camera_scores("t.s", scores_of(values, spread=0.5))
    widths = [np.ptp((over.low, over.high)) for over in (_tau(sure), _tau(unsure))]
    assert widths[0] == 0
    assert widths[1] > 1


def _tau(scores: Any) -> Any:
    return agreement_with_reality(scores, "sim_before", 1).agreement.tau


def test_a_score_that_a_camera_lacks_is_not_compared() -> None:
    scored = scores_of({"a": [1.0], "b": [2.0]})
    scored["b"] = []
    assert camera_scores("t.s", scored) is None
