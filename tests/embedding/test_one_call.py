"""A study or a diagnosis in one call, and what Python gives in place of a recipe's file."""

from __future__ import annotations

import json

import numpy as np
import pytest

import tacos
from tacos_framework.settings.yaml_reader import read_yaml
from tests.docs.pages import ROOT

MAPPING = read_yaml(ROOT / "recipes" / "headset_quick.yaml").data
SECONDS = {
    "rig.binning": 16,
    "nodes.world.frames": 4,
    "nodes.capture.light_texel_m": 0.2,
    "optimizer": {"use": "optimizer.random", "evaluations": 2},
    "executor": {"use": "executor.local"},
    "compare": None,
    "study": {"renew_episodes": "never", "finalists": 1},
    "test": None,
}


def test_a_mapping_is_read_as_its_file() -> None:
    assert tacos.load_recipe(MAPPING).as_data() == tacos.load_recipe("headset_quick").as_data()


def test_faults_of_a_mapping_are_those_of_a_file() -> None:
    with pytest.raises(tacos.UserError, match="unknown key 'optimiser'"):
        tacos.load_recipe({**MAPPING, "optimiser": {}})


def test_what_no_file_can_hold_is_named() -> None:
    with pytest.raises(tacos.UserError, match="a float64") as refused:
        tacos.load_recipe({**MAPPING, "seed": np.float64(3)})
    assert "float()" in refused.value.faults[0].remedy


def test_a_study_in_one_call_gives_its_candidates(tmp_path) -> None:
    result = tacos.design(MAPPING, out=tmp_path / "out", sets=SECONDS)
    assert [row["product"] for row in result.rows("candidates")] == [None, None]
    assert len(repr(result)) < 300


def test_a_diagnosis_is_read_as_tables(tmp_path) -> None:
    cause = {
        "effect": "effect.prnu",
        "present": 0.9,
        "closure": {"value": 0.8},
        "parameters": {"sigma": {"value": 0.01, "ci": [0.008, 0.012], "unit": "1"}},
    }
    found = {
        "verdict": "explained",
        "gap": {"before": 4.0, "after": 1.0},
        "causes": [cause],
        "where": [{"stage": "pixel", "statistic": "prnu", "z": 9.0, "captures": ["wall", "cap"]}],
    }
    (tmp_path / "result.json").write_text(json.dumps({"diagnosis": found}))
    result = tacos.read_diagnosis(tmp_path)
    assert repr(result) == "<diagnosis: explained, effect.prnu; gap 4 -> 1 floors>"
    assert result.rows("causes")[0]["high"] == 0.012
    assert result.rows("where")[0]["captures"] == "wall, cap"


def test_a_study_is_no_diagnosis(tmp_path) -> None:
    (tmp_path / "result.json").write_text('{"cameras": {}}')
    with pytest.raises(tacos.UserError, match="not the result of a diagnosis"):
        tacos.read_diagnosis(tmp_path)
