"""A study of toys whose truth is known, run once: cameras of 90 degrees are best, whatever their sensor."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import toy_plugin
from toy_study import FROM_CATALOG, merged, run

from tacos_framework.hookspecs import hookimpl
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Recipe
from tacos_framework.study.record import StudyRecord

SEARCHED = {
    "optimizer": {
        "use": "optimizer.genetic",
        "population": 8,
        "keep": 2,
        "parents": 4,
        "generations": 5,
    },
    "study": {"episodes": 3},
    "compare": {"cameras": ["oak_d_pro_wide", "flea3", "basler_dart"], "evaluations": 4},
    "test": {"seed": 9, "frames": 2, "episodes": 8, "most_episodes": 12},
}
"""Sections of a study that is large enough to be analysed."""


class Keeper:
    """Keeps the record of a study."""

    record: StudyRecord | None = None

    @hookimpl
    def tacos_analyse_study(self, record: StudyRecord) -> dict[str, Any]:
        self.record = record
        return {}


def with_toys(*observers: Any) -> Plugins:
    """The toys, the default plugins, and these that observe."""
    plugins = Plugins()
    for name in ("tacos_plugins.plugin", "tacos_worlds.plugin"):
        plugins.register(__import__(name, fromlist=["plugin"]))
    plugins.register(toy_plugin)
    for number, observer in enumerate(observers):
        plugins.register(observer, f"observer-{number}")
    return plugins


def from_catalog(**sections: Any) -> Recipe:
    """A recipe that chooses a sensor, with `sections` put over it."""
    return Recipe.model_validate(merged(merged(FROM_CATALOG, SEARCHED), sections))


@lru_cache
def recorded() -> StudyRecord:
    keeper = Keeper()
    run(from_catalog(), with_toys(keeper), Path(mkdtemp()) / "out")
    assert keeper.record is not None
    return keeper.record
