"""Studies side by side: what is compared with what, and going on with a broken run."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml
from toy_study import LEARNER, toy_recipe

from tacos_framework import ProcedureRecipe, UserError, run
from tacos_framework.recipe import Use
from tacos_framework.testing import ProcedureConformance
from tacos_validation.studies_compared.compare import CompareStudies
from tacos_validation.studies_compared.pairs import StudyOutcome, difference, scores_of, spread

VARIANTS = {"joint": {}, "frozen": {"nodes.learner.train.weights": "frozen"}}


@pytest.fixture(scope="module")
def study(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("study") / "toy.yaml"
    sections = {**LEARNER, "optimizer": {"population": 3, "keep": 1, "parents": 2, "generations": 2}}
    path.write_text(yaml.safe_dump(toy_recipe(**sections).as_data()))
    return path


def asked(path: Path, **settings: Any) -> ProcedureRecipe:
    base: dict[str, Any] = {
        "study": str(path),
        "variants": VARIANTS,
        "reference": "frozen",
        "seeds": [1, 2],
        "change": {"test.frames": 2},
    }
    return ProcedureRecipe(
        "procedure.compare-studies", base | settings, name="c", executor=Use(use="executor.local")
    )


@pytest.fixture(scope="module")
def compared(study, reporting_toys, tmp_path_factory) -> tuple[dict[str, Any], Path]:
    out = tmp_path_factory.mktemp("compared") / "out"
    return run(asked(study), out=out, plugins=reporting_toys), out


def test_each_variant_runs_with_each_seed_and_is_left_whole(compared):
    result, out = compared
    names = {f"{each['variant']}-{each['seed']}" for each in result["studies"]}
    assert names == {"joint-1", "joint-2", "frozen-1", "frozen-2"}
    assert {path.name for path in (out / "studies").iterdir()} == names
    for name in names:
        kept = json.loads((out / "studies" / name / "result.json").read_text())
        assert kept["seed"] == int(name[-1])
        assert (out / "studies" / name / "report.html").exists()
    rows = list(csv.DictReader((out / "studies.csv").read_text().splitlines()))
    assert [(row["variant"], row["seed"]) for row in rows] == [
        ("joint", "1"), ("frozen", "1"), ("joint", "2"), ("frozen", "2"),
    ]  # fmt: skip
    assert (out / "report.html").read_text().count("<svg") == 2, "once more for phones"


def test_twins_are_judged_on_the_same_scenes_and_seeds_on_others(compared):
    _, out = compared
    seeds = {
        path.name: yaml.safe_load((path / "recipe.yaml").read_text())["test"]["seed"]
        for path in (out / "studies").iterdir()
    }
    assert seeds["joint-1"] == seeds["frozen-1"]
    assert seeds["joint-2"] == seeds["frozen-2"] != seeds["joint-1"]


def test_differences_are_those_of_twins(compared):
    result, _ = compared
    scores = {(each["variant"], each["seed"]): each["scores"] for each in result["studies"]}
    by = [scores["joint", s]["learner.knowledge"] - scores["frozen", s]["learner.knowledge"] for s in (1, 2)]
    (found,) = (each for each in result["differences"] if each["score"] == "learner.knowledge")
    assert found["by"]["mean"] == pytest.approx(sum(by) / 2)
    assert found["better"] == sum(each > 0 for each in by)
    assert "joint is better in" in result["summary"]


def test_what_the_fitness_takes_comes_first_and_is_all_that_is_drawn(compared):
    result, out = compared
    scores = [each["score"] for each in result["differences"]]
    assert scores[:3] == ["fitness", "width.closeness", "learner.knowledge"]
    assert "width.brightness" in scores[3:]
    drawing = (out / "report.html").read_text().partition("<svg")[2].partition("</svg>")[0]
    assert "width: closeness" in drawing
    assert "brightness" not in drawing


def test_studies_that_are_done_are_kept_and_a_broken_one_goes_on(
    compared, study, toys, tmp_path, third_study_breaks_off
):
    whole, _ = compared
    out = tmp_path / "broken"
    with pytest.raises(KeyboardInterrupt):
        run(asked(study), out=out, plugins=toys)
    again = run(asked(study), out=out, plugins=toys, resume=True)
    assert third_study_breaks_off == ["joint-1", "frozen-1", "joint-2", "joint-2", "frozen-2"]
    assert [each["scores"] for each in again["studies"]] == [each["scores"] for each in whole["studies"]]


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"reference": "frosen"}, "Did you mean 'frozen'"),
        ({"seeds": [1, 1]}, "a seed stands twice"),
        ({"variants": {"a/b": {}, "frozen": {}}}, "part of a folder's"),
        ({"study": "optimizers_compared"}, "is no study"),
        ({"change": {"test": None}}, "has no test"),
        ({"variants": {"joint": {"nodes.learner.use": "task.toy-lerner"}, "frozen": {}}}, "variants.joint"),
    ],
)
def test_what_cannot_be_compared_is_refused_before_anything_is_run(study, toys, tmp_path, settings, said):
    with pytest.raises(UserError) as caught:
        run(asked(study, **settings), out=tmp_path / "out", plugins=toys)
    assert said in str(caught.value)
    assert not (tmp_path / "out" / "studies").exists()


def outcome(variant: str, seed: int, **scores: float) -> StudyOutcome:
    return StudyOutcome(variant, seed, scores, {}, 0, 0.0)


def test_a_difference_is_taken_seed_by_seed():
    outcomes = [
        outcome("a", 1, fitness=1.0),
        outcome("b", 1, fitness=0.5),
        outcome("a", 2, fitness=9.0),
        outcome("b", 2, fitness=9.5),
        outcome("a", 3, fitness=4.0),
    ]
    found = difference(outcomes, "a", "b", "fitness")
    assert (found.by.mean, found.by.standard_error, found.by.seeds) == (0.0, 0.5, 2)
    assert found.better == 1
    assert spread([2.0]).standard_error is None


def test_scores_that_a_study_lacks_are_left_out():
    outcomes = [outcome("a", 1, x=1.0, y=2.0, fitness=3.0), outcome("b", 1, x=1.0, fitness=1.0)]
    assert scores_of(outcomes) == ["fitness", "x"]


class TestCompareStudies(ProcedureConformance):
    component = CompareStudies
    files = ("report.html", "studies.csv", "studies/joint-1/result.json")

    @pytest.fixture(autouse=True)
    def _on_a_toy(self, study, toys):
        self.config = asked(study, seeds=[1]).settings  # type: ignore[misc]
        self.plugins = toys

    def comparable(self, result: Mapping[str, Any]) -> Mapping[str, Any]:
        studies = [{k: v for k, v in each.items() if k != "seconds"} for each in result["studies"]]
        return {**super().comparable(result), "studies": studies}
