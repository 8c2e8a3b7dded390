"""A procedure's recipe, checked against the installed plugins."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from tacos_framework.contracts import ProcedureBase, optional
from tacos_framework.errors import Fault, UserError, did_you_mean
from tacos_framework.plugins import Plugins, calling
from tacos_framework.recipe import Use
from tacos_framework.recipe.procedure import SHARED_KEYS, ProcedureRecipe
from tacos_framework.settings import Settings, also_called, check, with_paths_from


@dataclass(frozen=True)
class ProcedurePlan:
    """A procedure that was checked: its class, its settings, its executor."""

    recipe: ProcedureRecipe
    cls: type[Any]
    config: Settings
    executor: str
    executor_cls: type[Any]
    executor_config: Settings

    def as_data(self) -> dict[str, Any]:
        """The resolved recipe as plain data: every default filled in, paths found."""
        settings = self.config.model_dump(mode="json", by_alias=True)
        return replace(self.recipe, settings=settings).as_data()

    @property
    def asks_for(self) -> frozenset[str]:
        """The keywords of its `run`."""
        return frozenset(inspect.signature(self.cls.run).parameters) - {"self"}


def plan_procedure(recipe: ProcedureRecipe, plugins: Plugins, faults: Sequence[Fault] = ()) -> ProcedurePlan:
    """Check a procedure's recipe against the installed plugins.

    Raises `UserError` with `faults` and all that are found here.
    """
    found = list(faults)
    cls, config = _configured(recipe, plugins, "procedure", recipe.use, recipe.settings, (), found)
    where = recipe.executor or Use(use=plugins.default("executor", where=recipe.where(("executor",))))
    executor, executor_config = _configured(
        recipe, plugins, "executor", where.use, where.settings, ("executor",), found
    )
    if found or cls is None or config is None or executor is None or executor_config is None:
        raise UserError(recipe.without_echoes(found))
    _check_itself(recipe, plugins, cls, config)
    return ProcedurePlan(recipe, cls, config, where.use, executor, executor_config)


def _check_itself(recipe: ProcedureRecipe, plugins: Plugins, cls: type[Any], config: Settings) -> None:
    """Let a procedure look for faults in what its settings name."""
    if not callable(optional(cls, ProcedureBase, "check")):
        return
    offered = {"seed": recipe.seed, "plugins": plugins}
    asked = inspect.signature(cls.check).parameters
    with calling(recipe.use, plugins.distribution_of(recipe.use), "check"):
        cls(config).check(**{name: value for name, value in offered.items() if name in asked})


def _configured(
    recipe: ProcedureRecipe,
    plugins: Plugins,
    kind: str,
    use: str,
    settings: Mapping[str, Any],
    path: tuple[str | int, ...],
    faults: list[Fault],
) -> tuple[type[Any] | None, Settings | None]:
    if not use:
        return None, None
    try:
        cls = plugins.resolve(use, kind, where=recipe.where((*path, "use")))
    except UserError as error:
        faults.extend(error.faults)
        return None, None
    settings = with_paths_from(lambda name: recipe.folder_of((*path, name)), cls.Config, settings)
    config, found, _ = check(cls.Config, dict(settings), lambda below: recipe.where((*path, *below)))
    faults.extend(_with_shared_keys(cls, found) if kind == "procedure" else found)
    return cls, config


def _with_shared_keys(cls: type[Any], faults: Sequence[Fault]) -> list[Fault]:
    """Suggest also the keys that every procedure's recipe has."""
    known = [*SHARED_KEYS, "use", *cls.Config.model_fields]
    suggested = []
    for fault in faults:
        name = fault.what.removeprefix("unknown key ").strip("'")
        if fault.what == "unknown key 'effects'":
            takes_some = "a study, or a procedure with the setting effects"
            suggested.append(
                Fault(fault.where, "this procedure takes no effects", takes_some, "Leave out --with.")
            )
            continue
        unknown = fault.what.startswith("unknown key") and "." not in name
        remedy = did_you_mean(name, known, also_called(cls.Config)) if unknown else fault.remedy
        suggested.append(Fault(fault.where, fault.what, fault.expected, remedy))
    return suggested
