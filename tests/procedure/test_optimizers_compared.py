"""Optimizers side by side: what they are charged, what comes out, going on with a broken run."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from toy_study import FROM_CATALOG

from tacos_framework import ProcedureRecipe, UserError, run
from tacos_framework.recipe import Use
from tacos_framework.study.progress import Silent
from tacos_framework.testing import ProcedureConformance
from tacos_framework.testing.procedure import InThisProcess
from tacos_validation.optimizers_compared.compare import CompareOptimizers
from tacos_validation.optimizers_compared.contest import Moment, Run
from tacos_validation.optimizers_compared.standings import (
    best_after,
    curve,
    middle,
    reached,
    standing,
)

OPTIMIZERS = {
    "genetic": {"use": "optimizer.genetic", "population": 6, "keep": 2, "parents": 3, "generations": 50},
    "random": {"use": "optimizer.random", "evaluations": 500},
    "cma-es": {"use": "optimizer.cma-es", "evaluations": 500},
}


LOCAL = Use(use="executor.local")


@pytest.fixture(scope="module")
def problem(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("problem") / "toy.yaml"
    path.write_text(yaml.safe_dump(dict(FROM_CATALOG)))
    return path


@pytest.fixture(scope="module")
def compared(problem, toys, tmp_path_factory) -> tuple[dict[str, Any], Path]:
    """A comparison that several tests look at: its result and its folder."""
    out = tmp_path_factory.mktemp("compared") / "out"
    return run(asked(problem), out=out, plugins=toys), out


def asked(path: Path, **settings: Any) -> ProcedureRecipe:
    base = {
        "problem": str(path),
        "optimizers": OPTIMIZERS,
        "seeds": 2,
        "evaluations": 12,
        "reference": {"optimizer": "genetic", "rounds": 2},
    }
    return ProcedureRecipe("procedure.compare-optimizers", base | settings, name="c", executor=LOCAL)


def rows(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text().splitlines()))


def test_every_run_spends_the_same_images(compared):
    result, out = compared
    found = rows(out / "curves.csv")
    last = {(row["optimizer"], row["scheme"], row["seed"]): row for row in found}
    assert len(last) == 3 * 2 * 2
    assert {row["images"] for row in last.values()} == {"36"}  # 12 candidates of 3 frames
    assert result["images"] == 36
    assert len(result["standings"]) == 6
    assert result["evaluated"] >= 3 * 2 * 2 * 12  # those that break the constraint came on top
    assert min(float(row["regret"]) for row in found) == 0


def test_the_target_is_the_reference_after_its_rounds(compared):
    result, out = compared
    best = {
        row["seed"]: float(row["best_fitness"])
        for row in rows(out / "curves.csv")
        if (row["optimizer"], row["scheme"]) == ("genetic", "quantized") and int(row["round"]) <= 2
    }
    assert result["target"] == pytest.approx(np.median(list(best.values())))
    assert result["target_images"] <= 12 * 3
    assert result["target_rendered"] <= result["target_images"]


def test_the_report_is_one_file_that_fetches_nothing(compared):
    result, out = compared
    page = (out / "report.html").read_text()
    assert "mathdefault" not in page  # numbers at the axes, not the markup of matplotlib
    assert page.count("<svg") == 4  # two schemes, images and seconds
    assert "Images to the target" in page
    assert 'src="http' not in page
    assert 'href="http' not in page
    assert "genetic, quantized, 2 rounds" in result["summary"]
    assert len(rows(out / "standings.csv")) == 6


def test_equal_recipes_give_equal_fitness(compared, problem, toys, tmp_path):
    run(asked(problem), out=tmp_path / "again", plugins=toys)
    first, second = (
        [{**row, "seconds": ""} for row in rows(out / "curves.csv")]
        for out in (compared[1], tmp_path / "again")
    )
    assert first == second


def test_a_broken_run_goes_on_and_evaluates_nothing_twice(compared, problem, toys, tmp_path):
    import toy_plugin

    whole, finished = compared
    out = tmp_path / "broken"
    out.mkdir()
    (out / "recipe.yaml").write_bytes((finished / "recipe.yaml").read_bytes())
    kept = (finished / "evaluations.jsonl").read_text().splitlines()
    (out / "evaluations.jsonl").write_text("\n".join(kept[:60]) + '\n{"key": "cut sho')
    before = toy_plugin.WidthTask.begun
    again = run(asked(problem), out=out, plugins=toys, resume=True)
    lines = [json.loads(line) for line in (out / "evaluations.jsonl").read_text().splitlines()]
    assert [line["key"] for line in lines] == [json.loads(line)["key"] for line in kept]
    scored = sum(line["fitness"] is not None for line in lines[60:])
    assert toy_plugin.WidthTask.begun - before <= scored + 1  # and one to warm up
    for ours, theirs in zip(again["standings"], whole["standings"], strict=True):
        for key in ("final", "regret", "images", "success", "unseen"):
            assert ours[key] == theirs[key]


def test_optional_optimizers_are_left_out_with_a_note(problem, toys, tmp_path):
    optimizers = {**OPTIMIZERS, "ghost": {"use": "optimizer.ghost"}}
    result = run(asked(problem, optimizers=optimizers, optional=["ghost"]), out=tmp_path / "o", plugins=toys)
    assert {row["optimizer"] for row in result["standings"]} == set(OPTIMIZERS)
    assert any(note.startswith("ghost was left out") for note in result["comparison_notes"])


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"optimizers": {**OPTIMIZERS, "ghost": {"use": "optimizer.ghost"}}}, "optimizer.ghost"),
        ({"optimizers": {"genetic": {"use": "optimizer.genetic", "keep": 99}}}, "optimizers.genetic"),
        ({"reference": {"optimizer": "genetics"}}, "Did you mean 'genetic'?"),
        ({"schemes": ["discrete"]}, "the reference runs under quantized, which schemes leaves out"),
        ({"optional": ["genetic"]}, "the reference cannot be optional"),
        ({"problem": "no_such_problem"}, "there is no such recipe"),
        ({"problem": "optimizers_compared"}, "is no study"),
    ],
)
def test_what_cannot_be_compared_is_refused(problem, toys, tmp_path, settings, said):
    with pytest.raises(UserError) as raised:
        run(asked(problem, **settings), out=tmp_path / "out", plugins=toys)
    assert said in str(raised.value)


def test_a_run_that_stops_itself_is_named(problem, toys, tmp_path):
    optimizers = {**OPTIMIZERS, "random": {"use": "optimizer.random", "evaluations": 5}}
    result = run(asked(problem, optimizers=optimizers), out=tmp_path / "out", plugins=toys)
    assert (
        "Not all runs spent their budget. random: all 5 candidates were evaluated."
        in (result["comparison_notes"])
    )


class TestCompareOptimizers(ProcedureConformance):
    component = CompareOptimizers
    files = ("report.html", "curves.csv", "standings.csv", "evaluations.jsonl")

    @pytest.fixture(autouse=True)
    def _on_a_toy(self, problem, toys):
        self.config = asked(problem, seeds=1, evaluations=4).settings  # type: ignore[misc]
        self.toys = toys

    def run(self, out: Path, seed: int = 1) -> Mapping[str, Any]:
        out.mkdir()
        return self.make().run(
            out=out, seed=seed, plugins=self.toys, executor=InThisProcess(), progress=Silent(), resume=False
        )

    def comparable(self, result: Mapping[str, Any]) -> Mapping[str, Any]:
        standings = [
            {key: value for key, value in each.items() if key not in ("seconds", "thought_ms")}
            for each in result["standings"]
        ]
        return {**super().comparable(result), "standings": standings}


# standings --------------------------------------------------------------------------------------------------


def a_run(*best: float) -> Run:
    """A run that spends 10 images and 2 seconds on each candidate."""
    moments = [Moment(i, i, 10 * i, 2.0 * i, value) for i, value in enumerate(best, start=1)]
    return replace(Run("x", "quantized", 0, None, 1000, 10), moments=moments)


def test_the_interval_of_the_median_is_that_of_order_statistics():
    found = middle([float(value) for value in range(1, 11)])
    assert (found.median, found.low, found.high) == (5.5, 2.0, 9.0)  # holds the median with 97.9 %
    assert middle([3.0, 1.0, 2.0]).low == 1.0


def test_the_interval_holds_the_median_as_often_as_it_says():
    rng = np.random.default_rng(1)
    held = [(m := middle(rng.normal(size=10).tolist())).low <= 0 <= m.high for _ in range(600)]
    assert np.mean(held) > 0.95


def test_what_half_of_the_runs_never_reach_is_never_reached():
    assert math.isinf(middle([1.0, 2.0, math.inf, math.inf]).median)
    assert middle([1.0, 2.0, 3.0, math.inf]).median == 2.5


def test_best_and_target_are_read_off_a_run():
    one = a_run(0.1, 0.5, 0.5, 0.9)
    assert best_after(one, 25, lambda m: m.images, -1) == 0.5
    assert best_after(one, 5, lambda m: m.images, -1) == -1
    assert reached(one, 0.5, lambda m: m.images) == 20
    assert reached(one, 0.5, lambda m: m.seconds) == 4.0
    assert math.isinf(reached(one, 1.0, lambda m: m.images))


def test_curves_are_medians_of_regret():
    drawn = curve(
        [a_run(0.1, 0.5), a_run(0.3, 0.4), a_run(0.2, 0.9)],
        np.array([5.0, 10.0, 20.0]),
        lambda m: m.images,
        best_known=1.0,
        worst_known=0.0,
    )
    np.testing.assert_allclose(drawn.median, [1.0, 0.8, 0.5])
    np.testing.assert_allclose(drawn.high, [1.0, 0.9, 0.6])


def test_success_is_counted_over_runs():
    runs = [a_run(0.1, 0.6), a_run(0.7), a_run(0.1, 0.2), a_run(0.0, 0.1, 0.8)]
    found = standing(runs, target=0.6, early_images=20, best_known=1.0, worst_known=0.0, unseen=[0.5, 0.7])
    assert found.success == 0.75
    assert found.success_early == 0.5
    assert found.unseen == pytest.approx(0.6)
    assert found.images.median == 25.0
