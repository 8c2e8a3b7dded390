"""The last lines of a study: the verdict as it is, and never a winner where there is none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tacos_framework.cli.run import summary

RESULT: dict[str, Any] = {
    "best": {"camera": {"pitch_deg": -12.5, "sensor": {"name": "IMX273"}}},
    "test": {"flea3": {"fitness": 1.0}, "designed": {"fitness": 2.0}},
    "decision": {"sentence": "On 8 unseen scenes it is better."},
    "frames_rendered": 72,
    "seconds": 50.0,
    "stopped": "all 8 candidates were evaluated",
}


def test_the_verdict_stands_below_the_figures(tmp_path: Path) -> None:
    assert summary(RESULT, tmp_path).splitlines() == [
        "Designed: pitch_deg -12.5, sensor IMX273",
        "  designed             fitness on unseen scenes 2.000",
        "  flea3                fitness on unseen scenes 1.000",
        "On 8 unseen scenes it is better.",
        "72 images in 50 s; all 8 candidates were evaluated.",
        f"Results: {tmp_path}",
    ]


def test_a_study_that_tells_nothing_apart_names_no_camera(tmp_path: Path) -> None:
    said = summary({**RESULT, "degenerate": "All score zero: give more light.", "decision": None}, tmp_path)
    assert said.startswith("All score zero: give more light.")
    assert "Designed" not in said


def test_frames_that_are_lost_to_light_are_said(tmp_path: Path) -> None:
    exposed = {"designed": {"saturated": 0.4, "dark": 0.0}, "flea3": {"saturated": 0.0, "dark": 0.1}}
    said = summary({**RESULT, "exposed": exposed}, tmp_path)
    assert "Sample frames of designed: 40% of pixels are saturated: shorten exposure_ms" in said
    assert "Sample frames of flea3" not in said
