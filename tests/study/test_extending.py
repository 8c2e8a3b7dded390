"""Studies that are extended end as if they had been begun with the larger budget."""

from __future__ import annotations

import json

import pytest
import toy_plugin
from toy_study import LEARNER, comparable, run, toy_recipe

from tacos_framework.errors import UserError
from tacos_framework.plan import make_plan

OPTIMIZERS = {
    "genetic": ({"population": 4, "keep": 1, "parents": 2}, "generations", 2),
    "random": ({"batch": 4}, "evaluations", 8),
    "physical-gp": ({"per_round": 2}, "evaluations", 8),
    "optuna": ({"batch": 4}, "evaluations", 8),
}


def recipe(name, budget, **sections):
    settings, key, _ = OPTIMIZERS[name]
    whole = toy_recipe(**LEARNER, study={"train_best": 1}, **sections)
    optimizer = {"use": f"optimizer.{name}", **settings, key: budget}
    return whole.model_validate({**whole.as_data(), "optimizer": optimizer})


def names_below(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.slow) if n == "physical-gp" else n for n in OPTIMIZERS],
)
def test_an_extended_study_equals_one_begun_with_the_larger_budget(toys, tmp_path, name):
    _, key, budget = OPTIMIZERS[name]
    run(recipe(name, budget), toys, tmp_path / "extended")
    extended = run(recipe(name, budget), toys, tmp_path / "extended", extend={key: budget})
    long = run(recipe(name, 2 * budget), toys, tmp_path / "long")
    assert comparable(extended) == comparable(long)
    names = [
        sorted(str(p.relative_to(tmp_path / n)) for p in (tmp_path / n).rglob("*"))
        for n in ("extended", "long")
    ]
    assert names[0] == names[1]
    again = run(
        recipe(name, budget), toys, tmp_path / "extended", resume=True
    )  # what it was extended to stays
    assert comparable(again) == comparable(long)


def test_an_interrupted_study_can_be_extended_too(toys, tmp_path, monkeypatch):
    monkeypatch.setattr(toy_plugin.WidthTask, "begun", 0)
    monkeypatch.setattr(toy_plugin.WidthTask, "interrupt_at", 6)
    assert run(recipe("genetic", 2), toys, tmp_path / "out")["stopped"] == "interrupted by the user"
    monkeypatch.setattr(toy_plugin.WidthTask, "interrupt_at", None)
    extended = run(recipe("genetic", 2), toys, tmp_path / "out", extend={"generations": 1})
    assert comparable(extended) == comparable(run(recipe("genetic", 3), toys, tmp_path / "long"))


def test_the_plan_of_a_study_is_extended_as_its_recipe_is(toys, tmp_path):
    run(recipe("genetic", 2), toys, tmp_path / "out")
    plan = make_plan(recipe("genetic", 2), toys)
    extended = run(plan, toys, tmp_path / "out", extend={"generations": 1})
    assert comparable(extended) == comparable(run(recipe("genetic", 3), toys, tmp_path / "long"))


def test_what_cannot_be_extended_is_refused_with_what_can(toys, tmp_path):
    run(recipe("genetic", 1), toys, tmp_path / "out")
    with pytest.raises(UserError, match="cannot be extended by 'population'") as caught:
        run(recipe("genetic", 1), toys, tmp_path / "out", extend={"population": 2})
    assert "--extend generations=10" in str(caught.value)


def test_the_budget_of_products_is_kept_exactly(toys, tmp_path):
    result = run(
        toy_recipe(rig={"binning": 200}, compare={"cameras": ["flea3"], "evaluations": 4}), toys, tmp_path
    )
    assert result["cameras"]["flea3"]["evaluations"] == 4  # a population is 6
    (line,) = map(json.loads, (tmp_path / "products.jsonl").read_text().splitlines())
    assert sum(not candidate["cached"] for candidate in line["candidates"]) == 4


def test_a_study_all_of_whose_candidates_fail_for_one_reason_ends_with_it(toys, tmp_path):
    result = run(
        toy_recipe(nodes={"width": {"fail_above_deg": 1}}, optimizer={"generations": 100}), toys, tmp_path
    )
    assert "could be scored, and all failed for one reason, the last: cannot judge" in result["stopped"]
    assert result["evaluations"] < 40
