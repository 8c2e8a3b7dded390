"""The guide says what to photograph, from what effects declare."""

from __future__ import annotations

import json
from typing import get_args

import pytest

from tacos_framework.cli import tacos_main
from tacos_framework.plugins import Plugins
from tacos_gap.captures.entries import Kind
from tacos_gap.hypotheses.candidates import candidates
from tacos_gap.photographs import guide

EFFECTS = candidates(Plugins.discover()).effects


def test_the_whole_round_takes_twenty_minutes_and_names_kinds_that_exist():
    assert sum(step.minutes for step in guide.STEPS) <= 20
    assert {step.kind for step in guide.STEPS} <= set(get_args(Kind))
    assert "tacos captures import" in list(guide.whole_round())[-1]


@pytest.mark.parametrize("name", sorted(EFFECTS))
def test_every_effect_has_an_answer(name):
    lines = list(guide.for_effect(name, EFFECTS))
    assert lines[0] == f"To see {name}"
    assert len(lines) > 1
    assert max(map(len, lines)) <= guide.WIDTH


def test_a_question_names_the_capture_that_settles_it(tmp_path, capsys):
    assert tacos_main(["captures", "guide", "vignetting"]) == 0
    assert "illumination-gradient: kind flat; rotated by 90 degrees" in capsys.readouterr().out
    found = {"cause_set": ["vignetting", "illumination-gradient"], "next_capture": None}
    (tmp_path / "diagnosis.json").write_text(json.dumps(found))
    assert tacos_main(["captures", "guide", "--for", str(tmp_path)]) == 0
    assert "flat: a wall" in capsys.readouterr().out
    assert tacos_main(["captures", "guide", "fog"]) == 2
    assert "there is no effect 'fog'" in capsys.readouterr().err
    assert tacos_main(["captures", "guide", "vigneting"]) == 2
    assert "Did you mean 'vignetting'?" in capsys.readouterr().err


def test_a_settled_diagnosis_asks_for_nothing(tmp_path):
    path = tmp_path / "diagnosis.json"
    path.write_text(json.dumps({"cause_set": ["jpeg"], "next_capture": None}))
    assert "leaves nothing open" in " ".join(guide.for_diagnosis(path, EFFECTS))
    path.write_text("[]")
    with pytest.raises(guide.UserError, match="is no diagnosis"):
        list(guide.for_diagnosis(path, EFFECTS))


def test_captures_that_were_not_diagnosed_are_to_be_diagnosed_first(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "captures.yaml").write_text("")
    assert tacos_main(["captures", "guide", "--for", "mine"]) == 2
    assert "`tacos-run diagnose --set captures=mine --out out`" in capsys.readouterr().err
    assert tacos_main(["captures", "guide", "mine"]) == 2
    assert "A diagnosis is named by --for." in capsys.readouterr().err
