"""``tacos settings``: what a component takes and gives, for the terminal."""

from __future__ import annotations

from collections.abc import Iterator
from textwrap import wrap

from pydantic import BaseModel

from tacos_framework import Plugins, Recipe
from tacos_plugins.authoring.reference.pages import (
    MUST_BE_GIVEN,
    SettingRow,
    facts_of,
    models_of,
    setting_rows,
)

RECIPE = "recipe"
"""The name by which the keys of a recipe are shown."""


def settings_text(use: str, *, width: int) -> str:
    """The facts and settings of a component by its full name, or the keys of a recipe.

    Raises `UserError` when no such component is installed, or what it needs is missing.
    """
    if use == RECIPE:
        return "\n".join(_model_lines(Recipe, width))
    component = Plugins.discover().component(use, where="tacos settings")
    lines = [component.use, *wrap(component.summary, width, initial_indent="  ", subsequent_indent="  ")]
    for fact in facts_of(component):
        lines += wrap(fact.replace("`", ""), width, initial_indent="  - ", subsequent_indent="    ")
    for title, model in models_of(component):
        lines += ["", title.replace("`", "")] if title else []
        lines += _model_lines(model, width)
    return "\n".join(lines)


def _model_lines(model: type[BaseModel], width: int) -> Iterator[str]:
    for name, says, rows in setting_rows(model):
        if name:
            yield ""
            yield from wrap(f"{name}: {says}", width)
        for row in rows:
            yield from _row_lines(row, width)


def _row_lines(row: SettingRow, width: int) -> Iterator[str]:
    takes = " ".join(filter(None, (row.takes.replace("`", ""), row.unit and f"[{row.unit}]")))
    default = row.default if row.default in ("", MUST_BE_GIVEN) else f"default {row.default}"
    yield from wrap(
        "; ".join(filter(None, (f"  {row.name:<20} {takes}", default))), width, subsequent_indent=" " * 8
    )
    yield from wrap(row.meaning.replace("`", ""), width, initial_indent=" " * 8, subsequent_indent=" " * 8)
