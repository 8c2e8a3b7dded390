"""The tutorial on diagnosing a gap, followed with fewer and smaller captures."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from tacos_framework.cli import run_main, tacos_main
from tacos_framework.plugins import Plugins
from tacos_gap.hypotheses.candidates import candidates
from tests.docs.pages import ROOT, blocks, commands, write_file

PAGE = ROOT / "docs/tutorials/diagnose_a_gap.md"
FEWER = {
    "rig.sensor.width_px": "160",
    "rig.sensor.height_px": "120",
    "rig.sensor.pixel_um": "12",
    "captures": "["
    "{id: dark, kind: dark, exposure_ms: [10], frames: 2}, "
    "{id: flat, kind: flat, scene: {use: scene.light-box}, level: [0.3, 0.7], frames: 2}, "
    "{id: edges, kind: edge, scene: {use: scene.slanted-edges, angle_deg: 5}, frames: 2}]",
}
CONSIDERED = {"vignetting", "defocus", "read-noise"}


@pytest.mark.gl
def test_the_effects_left_out_are_found_and_go_into_the_next_study(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shown = [line for block in blocks(PAGE) for line in commands(block)]
    for block in blocks(PAGE):
        if block.title is not None:
            write_file(block, tmp_path)
    simulate, diagnose, patched = (shlex.split(line)[1:] for line in shown[:3])

    smaller = [word for key, value in FEWER.items() for word in ("--set", f"{key}={value}")]
    assert tacos_main([*simulate, *smaller, "--quiet"]) == 0

    without = sorted(set(candidates(Plugins.discover()).effects) - CONSIDERED)
    assert run_main([*diagnose, "--set", f"without={json.dumps(without)}", "--quiet"]) == 0
    found = json.loads(Path("out/diagnosis.json").read_text("utf-8"))
    assert {cause["effect"] for cause in found["causes"]} == {"vignetting", "defocus"}
    assert Path("out/report.html").is_file()

    assert run_main([*patched, "--check"]) == 0
