"""What steps of a simulation change in a ranking: the statistics on tables, the procedure on a toy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import yaml
from scipy.stats import ttest_rel
from toy_study import FROM_CATALOG, merged

from tacos_framework import ProcedureRecipe, UserError, run
from tacos_framework.recipe import Use
from tacos_framework.testing import ProcedureConformance
from tacos_validation.ablation.compare import WHOLE, Ablation
from tacos_validation.ablation.order import is_worse

PARTS = ["PYTHON300", "LUX1310", "IMX432", "IMX252"]


@pytest.fixture(scope="module")
def asked(tmp_path_factory) -> dict[str, Any]:
    path = tmp_path_factory.mktemp("study") / "toy.yaml"
    path.write_text(yaml.safe_dump(merged(FROM_CATALOG, {"study": {"episodes": 3}})))
    return {
        "study": str(path),
        "without": {
            "nothing": {"notes": ["the same study"]},
            "what counts": {"fitness": [{"score": "width.brightness", "weight": -1}]},
        },
        "cameras": {
            "parts": PARTS,
            "match": {"focal_length_mm": {"hfov_deg": 81.5}},
            "at": {"pitch_deg": -20},
        },
        "resamples": 20,
    }


@pytest.mark.parametrize(("shift", "seed"), [(0.05, 1), (0.3, 2), (1.0, 3), (-0.5, 4), (0.2, 5)])
def test_a_camera_is_worse_as_a_paired_test_has_it(shift: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    best = rng.normal(size=6)
    other = best - shift + rng.normal(size=6) * 0.3
    table = {"best": best, "other": other}
    found = is_worse("other", "best", lambda name, scenes: float(table[name][scenes[0]]), 6, 0.95)
    test = ttest_rel(other, best)
    assert found == (test.statistic < 0 and test.pvalue < 0.05)
    assert not is_worse("best", "best", lambda name, scenes: float(table[name][scenes[0]]), 6, 0.95)


def test_what_changes_nothing_keeps_the_order_and_what_turns_it_does_not(asked, toys, tmp_path) -> None:
    recipe = ProcedureRecipe("procedure.ablation", asked, name="a", executor=Use(use="executor.local"))
    result = run(recipe, out=tmp_path / "out", plugins=toys)
    whole, same, other = result["orders"]
    assert [each["variant"] for each in (whole, same, other)] == [WHOLE, "nothing", "what counts"]
    for each in (whole, same):
        assert (each["agreement"]["tau"], each["moved"]) == (1, 0)
        assert each["best"] in each["equal"]
    assert same["fitness"] == whole["fitness"]
    assert other["agreement"]["tau"] is None or other["agreement"]["tau"] < 1
    assert result["summary"].startswith("The ranking changes most what counts")
    assert (tmp_path / "out" / "table.csv").read_text().count("\n") == 4


def test_faults_of_all_variants_are_said_at_once(asked, toys) -> None:
    wrong = {**asked, "without": {"one": {"rig.binnin": 1}, "two": {"nodes.world.use": "scene.toi"}}}
    with pytest.raises(UserError) as refused:
        Ablation(Ablation.Config(**wrong)).check(plugins=toys)
    said = str(refused.value)
    assert "without.one" in said
    assert "without.two" in said


class TestAblation(ProcedureConformance):
    component = Ablation
    files = ("report.html", "table.csv", "scores.jsonl")

    @pytest.fixture(autouse=True)
    def _on_a_toy(self, asked, toys):
        self.config = {**asked, "scenes": 2}
        self.plugins = toys
