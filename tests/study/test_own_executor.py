"""A host hands over an executor of its own."""

from __future__ import annotations

import sys
from pathlib import Path

from tacos_framework import ProcedureRecipe
from tacos_framework import run as run_any
from tacos_framework.components import Component
from tacos_framework.hookspecs import hookimpl
from tacos_framework.plugins import Plugins
from tacos_framework.settings import Settings
from tests.toy_study import comparable, run, toy_recipe


class OwnExecutor:
    """Counts its jobs; remembers whether it was closed."""

    def __init__(self):
        self.jobs, self.closed = 0, False

    def map(self, evaluate, jobs):
        for job in jobs:
            self.jobs += 1
            yield evaluate(job)

    def close(self):
        self.closed = True


class Doubling:
    class Config(Settings):
        """No settings."""

    def __init__(self, config):
        pass

    def run(self, *, executor):
        return {"doubled": list(executor.map(_double, [1, 2])), "summary": "Doubled."}


def _double(number):
    return 2 * number


class Offer:
    @hookimpl
    def tacos_components(self):
        return [Component("procedure", "double", f"{__name__}:Doubling", summary="Doubles.")]


def test_it_evaluates_instead_of_the_recipes_and_stays_open(toys, tmp_path):
    own = OwnExecutor()
    result = run(toy_recipe(), toys, tmp_path / "own", executor=own)
    assert own.jobs >= result["evaluations"] > 0
    assert not own.closed
    assert comparable(result) == comparable(run(toy_recipe(), toys, tmp_path / "local"))


def test_procedures_get_it_too(tmp_path: Path, monkeypatch):
    monkeypatch.setitem(sys.modules, __name__, sys.modules[Doubling.__module__])
    plugins, own = Plugins.discover(), OwnExecutor()
    plugins.register(Offer())
    recipe = ProcedureRecipe("procedure.double", {}, name="twice")
    result = run_any(recipe, out=tmp_path / "run", plugins=plugins, executor=own)
    assert result["doubled"] == [2, 4]
    assert own.jobs == 2
    assert not own.closed
