"""Recipes that are no study: ``use: procedure.NAME`` at the top, and the procedure's settings beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from pydantic import create_model

from tacos_framework.errors import Fault
from tacos_framework.recipe.overrides import with_overrides
from tacos_framework.recipe.recipe import FORMAT, Recipe
from tacos_framework.recipe.sections import Use
from tacos_framework.recipe.written import Written
from tacos_framework.settings import Settings, check
from tacos_framework.settings.yaml_document import Document

SHARED_KEYS = ("tacos", "name", "seed", "notes", "executor")
"""Keys at the top of a procedure's recipe that are not settings of the procedure; as in `Recipe`."""


_SHARED_FIELDS: Any = {
    key: (Recipe.model_fields[key].annotation, Recipe.model_fields[key]) for key in SHARED_KEYS
}
_Heading: type[Settings] = create_model("_Heading", __base__=Settings, **_SHARED_FIELDS)


@dataclass(frozen=True)
class ProcedureRecipe(Written):
    """A procedure and its settings."""

    use: str
    """The component, ``procedure.NAME``."""
    settings: Mapping[str, Any]
    name: str = ""
    seed: int = 0
    executor: Use | None = None
    notes: tuple[str, ...] = ()
    """Notes for readers of the results."""
    document: Document | None = None

    @property
    def text(self) -> Document | None:
        return self.document

    def as_data(self) -> dict[str, Any]:
        return {
            "tacos": FORMAT,
            "name": self.name or self.use,
            "seed": self.seed,
            "use": self.use,
            **self.settings,
            **({"executor": self.executor.model_dump(mode="json")} if self.executor else {}),
            "notes": list(self.notes),
        }


def is_procedure(document: Document) -> bool:
    """True if a document is the recipe of a procedure."""
    return isinstance(document.data, dict) and "use" in document.data


def procedure_from(
    document: Document,
    sets: Mapping[str, Any],
    effects: Sequence[Mapping[str, Any]],
    places: Mapping[tuple[str | int, ...], str] = MappingProxyType({}),
) -> tuple[ProcedureRecipe, list[Fault]]:
    """A procedure's recipe from its document, and the faults of its form; see `parse_recipe`."""
    document, faults = with_overrides(document, sets, effects, places)
    faults += document.faults
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
    return ProcedureRecipe(use, data, document=document, **shared), document.without_echoes(faults)
