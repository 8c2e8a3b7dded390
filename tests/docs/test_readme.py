"""The example of the README runs; its study is cut down to one small floor, few frames and coarse pixels."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tests.docs.pages import ROOT, blocks

_SMALLER = {
    "rig.binning": 8,
    "nodes.world.frames": 4,
    "nodes.world.size_m": [11, 6],
    "nodes.capture.light_texel_m": 0.2,
    "optimizer": {"use": "optimizer.random", "evaluations": 2},
    "executor": {"use": "executor.local"},
    "test.frames": 4,
    "study": {"renew_episodes": "never", "finalists": 1},
    "test.episodes": 1,
    "test.most_episodes": None,
}


def test_example_runs(tmp_path: Path) -> None:
    (example,) = blocks(ROOT / "README.md", language="python")
    start = 'tacos.load_recipe("headset_quick", {'
    assert start in example.text
    text = example.text.replace(start, f"{start}**{_SMALLER!r}, ").replace(
        '"optimizer.evaluations": 12, ', ""
    )
    script = tmp_path / "example.py"
    script.write_text(text, "utf-8")
    done = subprocess.run(
        [sys.executable, str(script)], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == 2
    assert (tmp_path / "runs" / "from_python" / "report.html").is_file()
