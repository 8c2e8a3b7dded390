"""Optimizers side by side: what they are charged, how they are judged, going on with a broken run."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
import yaml
from toy_study import begun_as, toy_recipe

from tacos_framework import ProcedureRecipe, UserError, run
from tacos_framework.components import Component
from tacos_framework.contracts import Asked
from tacos_framework.hookspecs import hookimpl
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Use
from tacos_framework.settings import Settings, setting
from tacos_framework.store import Results
from tacos_framework.testing import ProcedureConformance
from tacos_framework.variables.design_space import DesignSpace
from tacos_validation.optimizers_compared.compare import CompareOptimizers
from tacos_validation.optimizers_compared.settings import CompareOptimizersConfig

OPTIMIZERS = {
    "genetic": {"use": "optimizer.genetic", "population": 6, "keep": 2, "parents": 3, "generations": 50},
    "random": {"use": "optimizer.random", "evaluations": 500},
    "frugal": {"use": "optimizer.toy-frugal"},
}
LOCAL = Use(use="executor.local")
FRAMES, EPISODES = 2, 2


class Frugal:
    """Scores each candidate on one scene, in turn, and recommends the first it ever drew."""

    class Config(Settings):
        width: float = setting(1.0, help="Not used.")

    told: ClassVar[list[Any]] = []

    def __init__(self, config: Config, *, space: DesignSpace, rng: np.random.Generator, problem: Any) -> None:
        self._space, self._rng, self._problem = space, rng, problem
        self._first: Any = None
        self._turn = 0

    expected_candidates = None

    def ask(self) -> list[Asked]:
        candidate = self._space.sample(self._rng)
        while self._problem.broken(candidate):
            candidate = self._space.sample(self._rng)
        self._first = self._first or candidate
        self._turn += 1
        return [Asked(candidate, (self._turn % self._problem.episodes,))]

    def tell(self, evaluated: Sequence[Any]) -> None:
        Frugal.told.extend(evaluated)

    def recommend(self, count: int) -> list[Any]:
        return [self._first][:count] if self._first else []

    def stop(self) -> str | None:
        return None

    def state(self) -> dict[str, Any]:
        return {}

    def restore(self, state: dict[str, Any]) -> None:
        pass


class _Contenders:
    @staticmethod
    @hookimpl
    def tacos_components() -> list[Component]:
        return [Component("optimizer", "toy-frugal", f"{__name__}:Frugal", summary="A toy.")]


@pytest.fixture(scope="module")
def plugins(toys) -> Plugins:
    import sys

    import toy_plugin

    found = Plugins.discover()
    found.register(toy_plugin)
    module = sys.modules[__name__]
    module.tacos_components = _Contenders.tacos_components  # type: ignore[attr-defined]
    found.register(module)
    return found


@pytest.fixture(scope="module")
def problem(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("problem") / "toy.yaml"
    changes = {
        "study": {"episodes": EPISODES},
        "nodes": {"world": {"frames": FRAMES}},
        "constraints": {"hfov_deg": {"max": 110}},
    }
    path.write_text(yaml.safe_dump(toy_recipe(**changes).as_data()))
    return path


def asked(path: Path, **changed: Any) -> ProcedureRecipe:
    base = {
        "problem": str(path),
        "grid": {"focal_length_mm": 0.25, "pitch_deg": 10},
        "held_out": {"seed": 77, "episodes": 2, "frames": 1},
        "reference": {"coarse": {"focal_length_mm": 1, "pitch_deg": 30}, "scenes": 1, "climbs": 2},
        "optimizers": OPTIMIZERS,
        "seeds": 2,
        "checkpoints": [4, 12, 40],
        "target": {"optimizer": "genetic", "rounds": 2},
        "against": ["genetic", "random"],
    }
    return ProcedureRecipe("procedure.compare-optimizers", base | changed, name="c", executor=LOCAL)


@pytest.fixture(scope="module")
def compared(problem, plugins, tmp_path_factory) -> tuple[dict[str, Any], Path]:
    """A comparison that several tests look at: its result and its folder."""
    out = tmp_path_factory.mktemp("compared") / "out"
    return run(asked(problem), out=out, plugins=plugins), out


def rows(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text().splitlines()))


def test_every_run_stands_at_every_checkpoint_with_no_more_images(compared):
    found = rows(compared[1] / "curves.csv")
    assert len(found) == 3 * 2 * 3
    assert all(int(row["images"]) <= int(row["checkpoint"]) for row in found)
    last = {int(row["images"]) for row in found if row["checkpoint"] == "40" and row["optimizer"] == "frugal"}
    assert last == {40}  # twenty candidates of one scene each


def test_regret_is_towards_the_best_camera_known(compared):
    result, out = compared
    regrets = [float(row["regret"]) for row in rows(out / "curves.csv") if row["regret"]]
    assert min(regrets) >= 0
    fitness = [float(row["held_out_fitness"]) for row in rows(out / "curves.csv") if row["regret"]]
    assert max(fitness) <= result["best_known"]


def test_the_reference_is_as_good_as_an_exhaustive_search(compared, problem, plugins, tmp_path):
    """With the whole fine grid as the coarse one, nothing better is found on a problem with one hill."""
    fine = {"coarse": {"focal_length_mm": 0.25, "pitch_deg": 10}, "scenes": 2, "climbs": 1}
    exhaustive = run(
        asked(problem, reference=fine, seeds=1, optimizers={"genetic": OPTIMIZERS["genetic"]}, against=[]),
        out=tmp_path / "out",
        plugins=plugins,
    )
    assert compared[0]["best_known"] == pytest.approx(exhaustive["best_known"], abs=1e-3)


def test_the_target_is_what_the_reference_recommends_after_its_rounds(compared):
    result, _ = compared
    assert result["target_of"] == "genetic after 2 rounds"
    assert result["target"] <= result["best_known"]
    assert 0 < result["target_images"] <= 12 * FRAMES * EPISODES  # two rounds of six, elites for nothing
    (genetic,) = (each for each in result["standings"] if each["optimizer"] == "genetic")
    assert set(genetic["ratios"]) == {"genetic", "random"}
    assert set(genetic["regret"]) == {"4", "12", "40"}


def test_optimizers_are_told_as_in_a_study(compared, problem, plugins, tmp_path):
    Frugal.told.clear()
    only = {"genetic": OPTIMIZERS["genetic"], "frugal": OPTIMIZERS["frugal"]}
    run(asked(problem, optimizers=only, seeds=1, against=[]), out=tmp_path / "out", plugins=plugins)
    assert sum(each.images for each in Frugal.told) == 40
    for each in Frugal.told:
        (scores,) = each.episodes.values()
        assert set(scores) == {"width.closeness", "width.brightness"}
        assert each.images in (0, FRAMES)  # nothing for what it has had before
    assert {number for each in Frugal.told for number in each.episodes} == {0, 1}


def test_runs_share_what_is_rendered(compared):
    result, out = compared
    table = [json.loads(line) for line in (out / "scores.jsonl").read_text().splitlines()]
    assert len({row["key"] for row in table}) == len(table)
    assert result["rendered"] == sum(row["images"] for row in table)
    assert all(row["images"] in (1, FRAMES) for row in table)  # what breaks a constraint is not rendered


def test_the_report_is_one_file_that_fetches_nothing(compared):
    result, out = compared
    page = (out / "report.html").read_text()
    assert "mathdefault" not in page  # numbers at the axes, not the markup of matplotlib
    assert page.count("<svg") == 2, "once more for phones"
    assert "Images to the target" in page
    assert 'src="http' not in page
    assert "genetic after 2 rounds" in result["summary"]
    assert not {"nan", "inf", "None"} & set(result["summary"].replace(",", " ").split())


def test_a_broken_run_goes_on_and_renders_nothing_twice(compared, problem, plugins, tmp_path):
    import toy_plugin

    whole, finished = compared
    out = begun_as(finished, tmp_path / "broken")
    kept = (finished / "scores.jsonl").read_text().splitlines()
    Results(out).write_lines("scores.jsonl", map(json.loads, kept[:60]))
    with (out / "scores.jsonl").open("a") as file:
        file.write('{"key": "cut sho')
    before = toy_plugin.WidthTask.begun
    again = run(asked(problem), out=out, plugins=plugins, resume=True)
    assert toy_plugin.WidthTask.begun - before == len(kept) - 60
    keys = [json.loads(line)["key"] for line in (out / "scores.jsonl").read_text().splitlines()]
    assert sorted(keys) == sorted(json.loads(line)["key"] for line in kept)
    assert (out / "curves.csv").read_text() == (finished / "curves.csv").read_text()
    assert again["best_known"] == whole["best_known"]


def test_larger_budgets_go_on_in_equal_ratios():
    config = CompareOptimizersConfig.model_validate(
        {
            **asked(Path("x")).settings,
            "checkpoints": [10, 20],
            "budgets": {"random": 70},
        }
    )
    assert config.checkpoints_of("genetic") == (10, 20)
    assert config.checkpoints_of("random") == (10, 20, 40, 70)


def test_optional_optimizers_are_left_out_with_a_note(problem, plugins, tmp_path):
    optimizers = {"genetic": OPTIMIZERS["genetic"], "ghost": {"use": "optimizer.ghost"}}
    wanted = asked(problem, optimizers=optimizers, optional=["ghost"], against=["ghost"], seeds=1)
    result = run(wanted, out=tmp_path / "o", plugins=plugins)
    assert {row["optimizer"] for row in result["standings"]} == {"genetic"}
    assert any(note.startswith("ghost was left out") for note in result["comparison_notes"])


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"optimizers": {**OPTIMIZERS, "ghost": {"use": "optimizer.ghost"}}}, "optimizer.ghost"),
        (
            {"optimizers": {"genetic": {"use": "optimizer.genetic", "keep": 99}}, "against": []},
            "optimizers.gen",
        ),
        ({"target": {"optimizer": "genetics"}}, "Did you mean 'genetic'?"),
        ({"budgets": {"random": 5}}, "ends before the last checkpoint"),
        ({"checkpoints": [40, 4]}, "rising numbers of images"),
        ({"optional": ["genetic"]}, "cannot be optional"),
        ({"problem": "no_such_problem"}, "there is no such recipe"),
        ({"problem": "optimizers_compared"}, "is no study"),
        ({"grid": {"pitch_deg": 5}}, "focal_length_mm has no step"),
        ({"grid": {"pitch_deg": 5, "focal_length_mm": 1, "zoom": 2}}, "no variable 'zoom'"),
        ({"grid": {"pitch_deg": 5, "focal_length_mm": 0}}, "above 0"),
        ({"reference": {"most": 3}}, "Give larger steps"),
        ({"change": {"constraints.hfov_deg.max": 1}}, "cameras tried keeps it"),
        ({"change": {"nodes.width.fail_above_deg": 1}}, "can be scored"),
        ({"change": {"nodes.width.crash_above_deg": 1}}, "ZeroDivisionError"),
    ],
)
def test_what_cannot_be_compared_is_refused(problem, plugins, tmp_path, changed, said):
    with pytest.raises(UserError) as raised:
        run(asked(problem, **changed), out=tmp_path / "out", plugins=plugins)
    assert said in str(raised.value)


def test_a_run_that_stops_itself_is_named(problem, plugins, tmp_path):
    optimizers = {"genetic": {**OPTIMIZERS["genetic"], "generations": 1}}
    wanted = asked(problem, optimizers=optimizers, against=[], seeds=1)
    notes = run(wanted, out=tmp_path / "out", plugins=plugins)["comparison_notes"]
    assert any(note.startswith("Not all runs spent their budget. genetic:") for note in notes)
    assert any("ended before round 2" in note for note in notes)


class TestCompareOptimizers(ProcedureConformance):
    component = CompareOptimizers
    files = ("report.html", "curves.csv", "standings.csv", "scores.jsonl")

    @pytest.fixture(autouse=True)
    def _on_a_toy(self, problem, plugins):
        only = {"genetic": OPTIMIZERS["genetic"]}
        self.config = asked(problem, seeds=1, optimizers=only, against=[]).settings  # type: ignore[misc]
        self.plugins = plugins

    def comparable(self, result: Mapping[str, Any]) -> Mapping[str, Any]:
        standings = [{**each, "thought_ms": 0} for each in result["standings"]]
        return {**super().comparable(result), "standings": standings}
