"""Recipes that are no study: checked and run as one."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from tacos_framework import ProcedureRecipe, UserError, load_recipe, run
from tacos_framework.components import Component
from tacos_framework.hookspecs import hookimpl
from tacos_framework.plan.procedure import plan_procedure
from tacos_framework.plugins import Plugins
from tacos_framework.settings import Settings, setting
from tacos_framework.store import Results
from tacos_report.verifying import verify


class Counting:
    """Squares the numbers below a limit."""

    class Config(Settings):
        limit: int = setting(help="Numbers to square.", ge=1)
        table: str = setting("", help="A file beside the recipe.", is_path=True)

    def __init__(self, config: Config) -> None:
        self.config = config

    def run(self, *, out: Path, seed: int, executor: Any, progress: Any) -> Mapping[str, Any]:
        progress.phase("Counting", self.config.limit)
        squares = []
        for square in executor.map(_square, range(self.config.limit)):
            squares.append(square + seed)
            progress.step(str(square))
        (out / "squares.txt").write_text("\n".join(map(str, squares)))
        return {"squares": squares, "summary": f"{len(squares)} squares, {self.config.table}"}


def _square(number: int) -> int:
    return number * number


class Continuing(Counting):
    """Goes on with a broken run."""

    def run(self, *, out: Path, resume: bool) -> Mapping[str, Any]:  # type: ignore[override]
        return {"resumed": resume}


class _Module:
    @staticmethod
    @hookimpl
    def tacos_components() -> list[Component]:
        return [
            Component("procedure", "count", f"{__name__}:Counting", summary="Counts."),
            Component("procedure", "continue", f"{__name__}:Continuing", summary="Goes on."),
        ]


@pytest.fixture
def plugins() -> Plugins:
    sys.modules.setdefault(__name__, sys.modules[Counting.__module__])
    plugins = Plugins.discover()
    plugins.register(_Module, name="counting")
    return plugins


def recipe(folder: Path, text: str) -> Path:
    path = folder / "count.yaml"
    path.write_text(text)
    return path


def test_a_procedure_runs_from_its_recipe(tmp_path, plugins):
    path = recipe(tmp_path, "tacos: 1\nname: squares\nuse: procedure.count\nlimit: 3\ntable: t.csv\n")
    (tmp_path / "t.csv").touch()
    result = run(load_recipe(path, sets={"limit": 4, "seed": 1}), out=tmp_path / "out", plugins=plugins)
    assert result["squares"] == [1, 2, 5, 10]
    assert result["summary"] == f"4 squares, {tmp_path / 't.csv'}"
    written = json.loads((tmp_path / "out" / "result.json").read_text())
    assert written == result
    assert written["procedure"] == "procedure.count"
    assert (tmp_path / "out" / "squares.txt").read_text() == "1\n2\n5\n10"
    again = load_recipe(tmp_path / "out" / "recipe.yaml")
    assert plan_procedure(again, plugins).config == plan_procedure(
        load_recipe(path), plugins
    ).config.model_copy(update={"limit": 4})


def test_a_procedure_runs_without_a_file(tmp_path, plugins):
    result = run(ProcedureRecipe("procedure.count", {"limit": 2}), out=tmp_path / "out", plugins=plugins)
    assert result["squares"] == [0, 1]


def test_a_second_run_does_not_go_into_the_same_folder(tmp_path, plugins):
    asked = ProcedureRecipe("procedure.count", {"limit": 2})
    run(asked, out=tmp_path / "out", plugins=plugins)
    with pytest.raises(UserError, match="not empty"):
        run(asked, out=tmp_path / "out", plugins=plugins)
    with pytest.raises(UserError, match="cannot go on with a broken run"):
        run(asked, out=tmp_path / "out", plugins=plugins, resume=True)


def test_what_changes_under_a_procedure_is_named_as_it_goes_on(tmp_path, plugins):
    table = tmp_path / "table.csv"
    table.write_text("1\n")
    asked = ProcedureRecipe("procedure.continue", {"limit": 1, "table": str(table)})
    out = tmp_path / "out"
    assert run(asked, out=out, plugins=plugins)["resumed"] is False
    assert run(asked, out=out, plugins=plugins, resume=True)["resumed"] is True
    table.write_text("2\n")
    change = "the files of settings is not the same: procedure.continue.table: table.csv changed"
    with pytest.raises(UserError, match=change) as caught:
        run(asked, out=out, plugins=plugins, resume=True)
    assert "--accept-changes" in str(caught.value)
    taken = run(asked, out=out, plugins=plugins, resume=True, accept_changes=True)
    assert taken["accepted"] == ((change,),)
    assert run(asked, out=out, plugins=plugins, resume=True)["accepted"] == ((change,),)


def test_the_files_of_a_procedure_are_verified(tmp_path, plugins):
    run(ProcedureRecipe("procedure.count", {"limit": 2}), out=tmp_path / "out", plugins=plugins)
    assert {each.name: each.damage for each in verify(tmp_path / "out")} == {
        "recipe.yaml": None,
        "manifest.json": None,
        "result.json": None,
        "log.txt": None,
        "run.sqlite": None,
    }
    result = tmp_path / "out" / "result.json"
    result.write_bytes(result.read_bytes().replace(b"squares, ", b"sqares, "))
    damaged = {each.name for each in verify(tmp_path / "out") if each.damage}
    assert damaged == {"result.json"}


def test_a_start_that_failed_refuses_no_other(tmp_path, plugins):
    out = tmp_path / "out"
    with Results.create(out, ProcedureRecipe("procedure.count", {"limit": 2}).as_data()):
        pass  # as a run leaves it that ends before it has computed anything
    assert {"recipe.yaml", "run.sqlite"} <= {path.name for path in out.iterdir()}
    result = run(ProcedureRecipe("procedure.count", {"limit": 3}), out=out, plugins=plugins)
    assert result["squares"] == [0, 1, 4]


def test_a_recipe_of_ones_own_is_not_written_over(tmp_path, plugins):
    (tmp_path / "log.txt").touch()
    (tmp_path / "recipe.yaml").write_text("use: procedure.count\n")
    with pytest.raises(UserError, match="not empty"):
        run(ProcedureRecipe("procedure.count", {"limit": 2}), out=tmp_path, plugins=plugins)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("name: n\nuse: procedure.count\nlimit: 3\n", "1:1: 'tacos' is missing"),
        ("tacos: 1\nname: n\nuse: procedure.cuont\nlimit: 3\n", "Did you mean 'procedure.count'?"),
        ("tacos: 1\nname: n\nuse: procedure.count\nlimt: 3\n", "4:1: unknown key 'limt'"),
        ("tacos: 1\nname: n\nuse: procedure.count\nlimt: 3\n", "'limit' is missing"),
        ("tacos: 1\nname: n\nuse: procedure.count\nlimit: 3\nsed: 3\n", "Did you mean 'seed'?"),
        ("tacos: 1\nname: n\nuse: procedure.count\nlimit: many\n", '4:1: limit is "many"'),
        ("tacos: 1\nname: n\nuse: procedure.count\nlimit: 3\nseed: -1\n", "5:1: seed is -1"),
        ("tacos: 1\nuse: procedure.count\nlimit: 3\n", "'name' is missing"),
        ("tacos: 1\nname: n\nuse: 3\n", "3:1: use is no name"),
        ("tacos: 1\nname: n\nuse: task.orb-features\n", "procedure"),
        (
            "tacos: 1\nname: n\nuse: procedure.count\nlimit: 3\nexecutor: {use: executor.cloud}\n",
            "executor.cloud",
        ),
    ],
)
def test_faults_are_told_with_their_place(tmp_path, plugins, text, expected):
    from tacos_framework.recipe.loading import read_any_recipe

    asked, faults = read_any_recipe(recipe(tmp_path, text))
    with pytest.raises(UserError) as caught:
        plan_procedure(asked, plugins, faults)
    assert expected in str(caught.value)
