"""Studies that go on for longer than they were begun for."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tacos_framework.contracts import OptimizerBase, optional
from tacos_framework.errors import Fault, UserError
from tacos_framework.plan import ConfiguredComponent
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Recipe
from tacos_framework.store import read_recipe
from tacos_framework.store.run import RECIPE


def budget_setting(optimizer: type[Any]) -> str | None:
    """The setting of an optimizer's class that says how long it goes on, where it may be raised later."""
    name: str | None = optional(optimizer, OptimizerBase, "budget")
    return name


def budget_of(optimizer: ConfiguredComponent) -> float | None:
    """Length of an optimizer's run; None if it declares no such setting."""
    name = budget_setting(optimizer.cls)
    return None if name is None else getattr(optimizer.config, name)


def without_budget(recipe: Mapping[str, Any], optimizer: ConfiguredComponent) -> dict[str, Any]:
    """A recipe as plain data, but for how long its optimizer goes on."""
    name = budget_setting(optimizer.cls)
    settings = {key: value for key, value in dict(recipe.get("optimizer") or {}).items() if key != name}
    return {**recipe, "optimizer": settings}


def for_resuming(recipe: Recipe, folder: Path, plugins: Plugins, extend: Mapping[str, int]) -> Recipe:
    """The recipe to go on with: as long as the run in the folder was extended to already, and longer.

    `recipe`: as it was begun with, or as it was extended to. `extend`: by how much to raise which setting of
    the optimizer: ``{"generations": 10}``.

    Raises `UserError` when the optimizer cannot be extended by that setting, or the run cannot be read.
    """
    optimizer = plugins.resolve(recipe.optimizer.use, "optimizer", where=recipe.where(("optimizer", "use")))
    name = budget_setting(optimizer)
    if wrong := [key for key in extend if key != name]:
        expected = f"{name}=N" if name else "an optimizer that declares what may be raised"
        raise UserError(
            Fault(
                f"--extend {wrong[0]}={extend[wrong[0]]}",
                f"{recipe.optimizer.use} cannot be extended by {wrong[0]!r}",
                expected,
                f"Extend {name}, as in --extend {name}=10." if name else "Start a new, longer run.",
            )
        )
    if name is None or not (folder / RECIPE).exists():
        return recipe
    kept = dict(read_recipe(folder).get("optimizer") or {})
    default = optimizer.Config.model_fields[name].default
    given = recipe.optimizer.settings.get(name, default)
    reached = kept.get(name, default)
    if not isinstance(reached, int) or not isinstance(given, int):
        return recipe
    wanted = max(given, reached) + extend.get(name, 0)
    if wanted == given:
        return recipe
    settings = {**recipe.optimizer.settings, name: wanted}
    longer = type(recipe.optimizer)(use=recipe.optimizer.use, **settings)
    return recipe.model_copy(update={"optimizer": longer})
