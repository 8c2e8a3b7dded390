"""A diagnosis is written whole or not at all."""

from __future__ import annotations

from pathlib import Path

import pytest

from tacos_framework.store import writers
from tacos_gap.procedures.diagnose import _write


def test_a_full_disk_leaves_the_earlier_diagnosis(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _write(tmp_path, {"causes": ["vignetting"]}, "effects: []\n")
    before = {path.name: path.read_text() for path in tmp_path.iterdir()}

    def full(_: int) -> None:
        raise OSError("no space left on the device")

    monkeypatch.setattr(writers, "to_disk", full)
    with pytest.raises(OSError, match="no space"):
        _write(tmp_path, {"causes": []}, "effects: [{use: effect.jpeg}]\n")
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == before
