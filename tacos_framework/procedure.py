"""Recipes that are no study: ``use: procedure.NAME`` at the top, and the procedure's settings beside it."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pydantic import create_model

from tacos_framework.errors import Fault, UserError, did_you_mean
from tacos_framework.overrides import with_overrides
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import FORMAT, Recipe, Use
from tacos_framework.settings import Settings, check, with_paths_from
from tacos_framework.yaml_reader import Document

SHARED_KEYS = ("tacos", "name", "seed", "notes", "executor")
"""Keys at the top of a procedure's recipe that are not settings of the procedure; as in `Recipe`."""


_SHARED_FIELDS: Any = {
    key: (Recipe.model_fields[key].annotation, Recipe.model_fields[key]) for key in SHARED_KEYS
}
_Heading: type[Settings] = create_model("_Heading", __base__=Settings, **_SHARED_FIELDS)


@dataclass(frozen=True)
class ProcedureRecipe:
    """What to run: a procedure and its settings.

    Parameters
    ----------
    use
        The component, ``procedure.NAME``.
    settings
        Its settings, as plain data.
    name
        What the run is called.
    seed
        Everything random follows from it.
    executor
        Where work is done.
    notes
        What a reader of the results should know.
    """

    use: str
    settings: Mapping[str, Any]
    name: str = ""
    seed: int = 0
    executor: Use = field(default_factory=lambda: Use(use="executor.local"))
    notes: tuple[str, ...] = ()
    document: Document | None = None

    def where(self, path: Sequence[str | int]) -> str:
        """File, line and column of a key; its dotted name for a recipe built in Python."""
        if self.document is not None:
            return self.document.where(tuple(path))
        return ".".join(map(str, ("recipe", *path)))

    @property
    def folder(self) -> Path | None:
        """The folder that relative paths in the recipe start from."""
        name = self.document.name if self.document else None
        return Path(name).parent if name and Path(name).is_file() else None

    def as_data(self) -> dict[str, Any]:
        """The recipe as plain data."""
        return {
            "tacos": FORMAT,
            "name": self.name or self.use,
            "seed": self.seed,
            "use": self.use,
            **self.settings,
            "executor": self.executor.model_dump(mode="json"),
            "notes": list(self.notes),
        }


def is_procedure(document: Document) -> bool:
    """Whether a document is the recipe of a procedure."""
    return isinstance(document.data, dict) and "use" in document.data


def procedure_from(
    document: Document, sets: Mapping[str, Any], effects: Sequence[Mapping[str, Any]]
) -> tuple[ProcedureRecipe, list[Fault]]:
    """A procedure's recipe from its document, and the faults of its form; see `read_recipe`."""
    document, faults = with_overrides(document, sets, effects)
    data = dict(document.data)
    if "tacos" not in data:
        faults.append(
            Fault(document.where(()), "'tacos' is missing", f"tacos: {FORMAT}", "Add it as the first line.")
        )
    heading = {key: data.pop(key) for key in SHARED_KEYS if key in data}
    checked, found, _ = check(_Heading, heading, document.where)
    faults += found
    shared: dict[str, Any] = (
        {key: getattr(checked, key) for key in SHARED_KEYS if key != "tacos"} if checked else {}
    )
    use = data.pop("use")
    if not isinstance(use, str):
        faults.append(Fault(document.where(("use",)), "use is no name", "procedure.NAME"))
        use = ""
    return ProcedureRecipe(use, data, document=document, **shared), faults


@dataclass(frozen=True)
class ProcedurePlan:
    """A procedure that was checked: its class, its settings, its executor."""

    recipe: ProcedureRecipe
    cls: type[Any]
    config: Settings
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

    Raises
    ------
    UserError
        With `faults` and all that are found here.
    """
    found = list(faults)
    cls, config = _configured(recipe, plugins, "procedure", recipe.use, recipe.settings, (), found)
    executor, executor_config = _configured(
        recipe, plugins, "executor", recipe.executor.use, recipe.executor.settings, ("executor",), found
    )
    if found or cls is None or config is None or executor is None or executor_config is None:
        raise UserError(found)
    return ProcedurePlan(recipe, cls, config, executor, executor_config)


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
    if recipe.folder is not None:
        settings = with_paths_from(recipe.folder, cls.Config, settings)
    config, found, _ = check(cls.Config, dict(settings), lambda below: recipe.where((*path, *below)))
    faults.extend(_with_shared_keys(cls, found) if kind == "procedure" else found)
    return cls, config


def _with_shared_keys(cls: type[Any], faults: Sequence[Fault]) -> list[Fault]:
    """Suggest also the keys that every procedure's recipe has."""
    known = [*SHARED_KEYS, "use", *cls.Config.model_fields]
    suggested = []
    for fault in faults:
        name = fault.what.removeprefix("unknown key ").strip("'")
        unknown = fault.what.startswith("unknown key") and "." not in name
        remedy = did_you_mean(name, known) if unknown else fault.remedy
        suggested.append(Fault(fault.where, fault.what, fault.expected, remedy))
    return suggested
