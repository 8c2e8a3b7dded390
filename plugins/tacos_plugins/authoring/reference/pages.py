"""Writes the reference pages that follow from the code.

The settings of a component are declared once, in its ``Config``; this page of the documentation, the checks
of a recipe and its error messages all read them from there.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import BaseModel

from tacos_framework import (
    NODE_KINDS,
    Component,
    Plugins,
    Recipe,
    TrainableBase,
    acts_after_noise,
    formation_order,
    hookspecs,
    optional,
    signature_of,
    type_name,
)

Schema = Mapping[str, Any]

NOTICE = "<!-- Written by `make docs` from the code; changes here are lost. -->"
MUST_BE_GIVEN = "must be given"
_TOO_LONG = "see below"
_LONGEST_DEFAULT = 60  # characters; the defaults of a longer mapping stand in a table of its own
_FAR = 1e5  # a bound so far off guards against slips, and tells a reader nothing
_BOUNDS = {"exclusiveMinimum": "> {}", "minimum": "≥ {}", "exclusiveMaximum": "< {}", "maximum": "≤ {}"}


def type_of(schema: Schema) -> str:
    """The values of a setting in words, from its JSON Schema.

    >>> type_of({"type": "array", "prefixItems": [{"type": "number"}, {"type": "number"}]})
    '[number, number]'
    >>> type_of({"anyOf": [{"enum": ["day", "night"], "type": "string"}, {"type": "null"}]})
    '`day` or `night` or nothing'
    """
    if "$ref" in schema:
        return f"*{schema['$ref'].rpartition('/')[2]}*"
    if "const" in schema:
        return f"`{schema['const']}`"
    if "enum" in schema:
        return " or ".join(f"`{value}`" for value in schema["enum"])
    for key in ("anyOf", "oneOf"):
        if key in schema:
            return " or ".join(type_of(member) for member in schema[key])
    kind = schema.get("type")
    if kind == "array" and "prefixItems" in schema:
        return f"[{', '.join(map(type_of, schema['prefixItems']))}]"
    if kind == "array":
        return f"list of {type_of(schema.get('items', {}))}"
    if kind == "object":
        named = schema.get("patternProperties", {}).values()
        values = next(iter(named), schema.get("additionalProperties"))
        return f"mapping of names to {type_of(values)}" if isinstance(values, dict) else "mapping"
    words = {"number": "number", "integer": "whole number", "string": "text", "null": "nothing"}
    return words.get(str(kind), "`true` or `false`" if kind == "boolean" else "anything")


def bounds_of(schema: Schema) -> str:
    """The bounds of a setting, ``"≥ 0, < 1"``; empty where there are none.

    >>> number_or_text = {"oneOf": [{"type": "number", "minimum": 0}, {"type": "string"}]}
    >>> bounds_of({"anyOf": [number_or_text, {"type": "null"}]})
    '≥ 0'
    """
    members = list(_forms_of(schema))
    found = [
        text.format(member[key])
        for member in members
        for key, text in _BOUNDS.items()
        if abs(member.get(key, _FAR)) < _FAR
    ]
    if (schema.get("minItems") or schema.get("minLength")) and "prefixItems" not in schema:
        found.append("not empty")
    return ", ".join(found)


def _forms_of(schema: Schema) -> Iterator[Schema]:
    """A schema, and those of the forms that it allows."""
    yield schema
    for key in ("anyOf", "oneOf"):
        for member in schema.get(key, ()):
            yield from _forms_of(member)


class SettingRow(NamedTuple):
    """A setting in words; `name` and `default` as a recipe has them."""

    name: str
    takes: str
    default: str
    unit: str
    meaning: str


def setting_rows(model: type[BaseModel]) -> Iterator[tuple[str, str, list[SettingRow]]]:
    """The settings of a model, then of each model inside it: its name, what it is, its rows.

    The name of the outer model is empty.
    """
    schema = model.model_json_schema(by_alias=True)
    models = schema.get("$defs", {})
    yield "", "", list(_rows(schema, models))
    for name, nested in models.items():
        if nested.get("properties"):
            yield name, _sentence(nested), list(_rows(nested, models))


def _rows(schema: Schema, models: Mapping[str, Schema]) -> Iterator[SettingRow]:
    required = schema.get("required", ())
    for name, field in schema.get("properties", {}).items():
        takes = ", ".join(filter(None, (type_of(field), bounds_of(field))))
        default = MUST_BE_GIVEN if name in required else _default(field)
        unit = "" if field.get("unit", "1") == "1" else field["unit"]
        model = models.get(field.get("$ref", "").rpartition("/")[2], {})
        yield SettingRow(name, takes, default, unit, _sentence(field) or _sentence(model))


def settings_table(model: type[BaseModel]) -> str:
    """The settings of a model and of the models inside it, as Markdown tables."""
    return "\n\n".join(
        f"*{name}*: {says}\n\n{_table(rows)}" if name else _table(rows)
        for name, says, rows in setting_rows(model)
    )


def _sentence(schema: Schema) -> str:
    return " ".join(str(schema.get("description", "")).partition("\n\n")[0].replace("``", "`").split())


def _table(rows: list[SettingRow]) -> str:
    if not rows:
        return "No settings."
    lines = ["| name | takes | default | unit | meaning |", "| --- | --- | --- | --- | --- |"]
    for row in rows:
        quoted = row.default in ("", MUST_BE_GIVEN, _TOO_LONG)
        default = row.default if quoted else f"`{row.default}`"
        cells = (f"`{row.name}`", row.takes, default, row.unit, row.meaning)
        lines.append(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |")
    return "\n".join(lines)


def _default(field: Schema) -> str:
    value = field.get("default")
    if value in (None, {}, [], ()):
        return ""
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= _LONGEST_DEFAULT else _TOO_LONG


def settings_page(components: Iterable[Component]) -> str:
    sections = [
        "# Settings of the components",
        NOTICE,
        "Every component that ships with tacos-framework: its ports, what it reports, and its settings. "
        "`tacos settings NAME` prints the same of any component that is installed, others' included.",
    ]
    for component in components:
        sections += component_page(component)
    return "\n\n".join(sections) + "\n"


def component_page(component: Component) -> Iterator[str]:
    """Ports, output and settings of a component: heading, facts and tables."""
    yield f"## {component.use}"
    yield component.summary
    if facts := facts_of(component):
        yield "\n".join(f"- {fact}" for fact in facts)
    for title, model in models_of(component):
        table = settings_table(model)
        yield f"{title}\n\n{table}" if title else table


def facts_of(component: Component) -> list[str]:
    """Ports, scores, stage, derived quantities and packages of a component."""
    facts = list(_facts(component.kind, component.load()))
    if component.requires:
        facts.append(f"needs: {', '.join(component.requires)}")
    return facts


def models_of(component: Component) -> Iterator[tuple[str, type[BaseModel]]]:
    """The settings of a component, then its variables or further keys, each with its title."""
    cls = component.load()
    yield "", cls.Config
    if component.kind == "rig":
        yield "Variables, to be designed or fixed:", cls.Variables
    if component.kind == "task" and optional(cls, TrainableBase, "Training"):
        yield "Further keys of `train:`", cls.Training


def _facts(kind: str, cls: type[Any]) -> Iterator[str]:
    if kind in NODE_KINDS:
        signature = signature_of(cls, kind)
        for port, taken in signature.inputs.items():
            yield f"input port `{port}`: {type_name(taken)}"
        if signature.output is not None:
            yield f"gives: {type_name(signature.output)}"
    if kind == "task":
        yield f"scores: {_listed(cls.scores)}"
    if kind == "effect":
        yield f"stage: {cls.stage}"
    if kind == "procedure":
        yield f"asks for: {_listed(name for name in inspect.signature(cls.run).parameters if name != 'self')}"
    if kind == "rig":
        quantities = (f"`{name}` [{unit}]" for name, unit in cls.derived_quantities.items())
        yield f"derived quantities: {', '.join(quantities)}"


def _listed(names: Any) -> str:
    return ", ".join(f"`{name}`" for name in names)


def effects_page(components: Iterable[Component]) -> str:
    """The effects in the order in which they act, with the values at which each is off."""
    effects = [component for component in components if component.kind == "effect"]
    ordered = sorted(effects, key=lambda effect: formation_order(effect.load()))
    lines = [
        "| effect | stage | side of the noise | off at | meaning |",
        "| --- | --- | --- | --- | --- |",
    ]
    for effect in ordered:
        cls = effect.load()
        side = "after it" if acts_after_noise(cls) else "before it"
        off = ", ".join(_off_value(cls, name, value) for name, value in cls.neutral.items())
        lines.append(f"| `{effect.name}` | {cls.stage} | {side} | {off} | {effect.summary} |")
    sections = [
        "# Effects",
        NOTICE,
        "The effects that ship with tacos-framework, in the order in which they act whatever the order of a "
        "recipe. `tacos settings effect.NAME` prints the bounds and meanings of one; "
        "[what effects are](../explanation/effects.md) explains them.",
        "\n".join(lines),
    ]
    return "\n\n".join(sections) + "\n"


def _off_value(cls: type[Any], name: str, value: Any) -> str:
    if value is None:
        return f"no `{name}`"
    extra = cls.Config.model_fields[name].json_schema_extra
    unit = "" if extra["unit"] == "1" else f" {extra['unit']}"
    plain = f"{value:g}" if isinstance(value, float) else value
    return f"`{name}` {plain}{unit}"


def recipe_page() -> str:
    """Every key of a recipe."""
    sections = [
        "# Keys of a recipe",
        NOTICE,
        "The keys at the top of a recipe, then those inside them. "
        "[The recipe](recipe.md) shows how they work together.",
        settings_table(Recipe),
    ]
    return "\n\n".join(sections) + "\n"


def hooks_page() -> str:
    """Every hook of `tacos_framework.hookspecs`."""
    sections = [
        "# Hooks",
        NOTICE,
        "What a plugin module may implement, each marked with `tacos_framework.hookspecs.hookimpl`. "
        "A hook may leave out parameters it does not need.",
    ]
    for name, hook in vars(hookspecs).items():
        if name.startswith("tacos_") and inspect.isfunction(hook):
            parameters = ", ".join(inspect.signature(hook).parameters)
            sections += [f"## `{name}({parameters})`", inspect.cleandoc(hook.__doc__ or "")]
    return "\n\n".join(sections).replace("``", "`") + "\n"


_OURS = ("tacos-framework", "tacos-validation")
"""The distributions of this repository: the pages do not depend on what else is installed."""


def default_components() -> list[Component]:
    """The components of this repository's distributions."""
    return [registered.component for registered in Plugins.discover() if registered.distribution in _OURS]


def pages() -> dict[str, Callable[[], str]]:
    """Each generated page of the repository and what writes it: ours, and those that plugins offer."""
    own: dict[str, Callable[[], str]] = {
        "effects.md": lambda: effects_page(default_components()),
        "hooks.md": hooks_page,
    }
    return own | {page.name: page.write for page in Plugins.discover().offers.reference_pages()}


def pages_of_the_site() -> dict[str, Callable[[], str]]:
    """Writers of the pages that the site alone has, by its title; `tacos settings` prints the same."""
    return {
        "Keys of a recipe": recipe_page,
        "Settings of the components": lambda: settings_page(default_components()),
    }


def main(folder: Path) -> None:
    for name, write in pages().items():
        (folder / name).write_text(write(), encoding="utf-8")
