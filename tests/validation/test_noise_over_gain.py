"""``tacos-run noise_over_gain``: models of noise over gain against tables of real cameras."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tacos_framework.cli import run_main
from tacos_validation.noise.gain_table import MeasuredCamera
from tacos_validation.noise.over_gain import figures_of, left_out_gains

SHARED = Path(__file__).parents[3] / "shared" / "data" / "catalogs" / "noise_over_iso.csv"


def simulated_camera(rng: np.random.Generator, number: int) -> MeasuredCamera:
    """A camera with noise before and after its gain, measured with 3 and 10 % of scatter."""
    gains = 100 * 2.0 ** np.arange(9)
    before, after = rng.uniform(1e-13, 1e-12), rng.uniform(1e-9, 3e-8)
    slopes = 3e-8 * gains * rng.lognormal(0, 0.03, 9)
    return MeasuredCamera(
        f"Own {number}", gains, slopes, (before * gains**2 + after) * rng.lognormal(0, 0.1, 9)
    )


def test_two_stages_predict_a_chain_of_two_stages_best() -> None:
    rng = np.random.default_rng(3)
    settings = [s for number in range(12) for s in left_out_gains(simulated_camera(rng, number))]
    found = {name: figures_of(settings, name) for name in ("affine", "electrons", "two-stages")}
    rms = {name: figures["intercept_rms_log2"] for name, figures in found.items()}
    assert rms["two-stages"] < 0.5 < rms["affine"]
    assert found["two-stages"]["within_25_percent_at_2_percent_signal"] > 0.9
    assert found["two-stages"]["coverage_90"] > 0.85


def test_left_out_gain_is_unknown_to_its_prediction() -> None:
    camera = simulated_camera(np.random.default_rng(4), 1)
    spoilt = MeasuredCamera(camera.name, camera.gains, camera.slopes.copy(), camera.intercepts.copy())
    spoilt.slopes[4] *= 7
    before, after = (list(left_out_gains(c))[4].predicted for c in (camera, spoilt))
    assert before == after


def test_recipe_writes_figures_and_a_page(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    lines = ["maker,model,iso,a,b"]
    for number in range(3):
        camera = simulated_camera(rng, number)
        rows = zip(camera.gains, camera.slopes, camera.intercepts, strict=True)
        lines += [f"Own,{number},{g:g},{a:.6g},{b:.6g}" for g, a, b in rows]
    data = tmp_path / "noise.csv"
    data.write_text("\n".join(lines))
    assert (
        run_main(["noise_over_gain", "--set", f"data={data}", "--out", str(tmp_path / "out"), "--quiet"]) == 0
    )
    result = json.loads((tmp_path / "out" / "result.json").read_text())
    outcome = result.get("outcome", result)
    assert outcome["settings"] == 27
    assert set(outcome["models"]["two-stages"]) == {
        "intercept_rms_log2",
        "within_25_percent_at_2_percent_signal",
        "coverage_90",
    }
    assert "Before and after the gain" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("maker,model,iso,a\nA,B,100,1e-6\n", "no column b"),
        ("maker,model,iso,a,b\nA,B,100,x,1e-9\nA,B,0,1e-6,nan\n", "line 3"),
        ("maker,model,iso,a,b\n", "has no measurements"),
        ("maker,model,iso,a,b\nA,B,100,1e-6,1e-9\n", "two gains"),
    ],
)
def test_table_that_cannot_serve_is_told(
    text: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = tmp_path / "noise.csv"
    data.write_text(text)
    assert (
        run_main(["noise_over_gain", "--set", f"data={data}", "--out", str(tmp_path / "out"), "--quiet"]) == 2
    )
    assert said in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.skipif(not SHARED.exists(), reason="needs the noise of real cameras in ../shared/data")
def test_two_stages_hold_on_real_cameras(tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run_main(["noise_over_gain", "--set", f"data={SHARED}", "--out", str(out), "--quiet"]) == 0
    result = json.loads((out / "result.json").read_text())
    found = result.get("outcome", result)["models"]["two-stages"]
    assert found["intercept_rms_log2"] <= 1.3
    assert found["within_25_percent_at_2_percent_signal"] >= 0.75
    assert 0.85 <= found["coverage_90"] <= 0.95
