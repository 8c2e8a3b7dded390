"""The whole check, as small as it gets."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest

from tacos_framework.recipe.loading import load_recipe
from tacos_framework.runner import run

SMALL = """
tacos: 1
name: small check
use: procedure.gap-blind-check
seed: 3
counts:
  {t0: 0, ladder: [8], natural: 0, t2: 0, t3: 0, t4: 0, t6: 0, t7: 0, t7_quiet: 0, speed: 0,
   effects: [black-level]}
width_px: 64
height_px: 48
captures: smallest
"""


@pytest.fixture(scope="module")
def checked(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict]:
    folder = tmp_path_factory.mktemp("check")
    (folder / "small.yaml").write_text(SMALL)
    return folder / "out", run(load_recipe(folder / "small.yaml"), out=folder / "out")


def test_it_reports_every_case(checked: tuple[Path, dict]) -> None:
    out, result = checked
    lines = [json.loads(line) for line in (out / "cases.jsonl").read_text().splitlines()]
    assert len(lines) == result["cases"] == 1
    assert lines[0]["truth"]["withheld"][0]["effect"] == "black-level"
    assert "error" not in lines[0]["answer"]
    assert set(lines[0]["answer"]["baselines"]) == set(result["baselines"]) - {"the diagnosis"}
    assert lines[0]["fresh_gaps"]["before"] > lines[0]["fresh_gaps"]["truth"]


def test_truths_are_those_that_were_committed_to(checked: tuple[Path, dict]) -> None:
    out, _ = checked
    for line in (out / "commitments.jsonl").read_text().splitlines():
        commitment = json.loads(line)
        content = (out / "truths" / f"{commitment['case']}.json").read_bytes()
        assert hashlib.sha256(content).hexdigest() == commitment["sha256"]
        assert len(json.loads(content)["salt"]) == 32


def test_captures_are_cleared_away_and_the_report_stands(checked: tuple[Path, dict]) -> None:
    out, result = checked
    assert not (out / "made").exists()
    assert "checked blind" in (out / "report.html").read_text()
    assert "T5 is left out" in result["summary"]
