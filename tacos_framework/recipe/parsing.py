"""From YAML to the recipe of a study: all faults of its form, each with its line and column.

Whether its components exist and fit together is the business of `tacos_framework.plan`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Annotated, Any

from tacos_framework.errors import Fault, UserError, did_you_mean
from tacos_framework.recipe.overrides import with_overrides
from tacos_framework.recipe.recipe import FORMAT, Recipe
from tacos_framework.recipe.sections import ExposureControl, Scenarios
from tacos_framework.settings.checking import check, clash_fault
from tacos_framework.settings.yaml_document import Document
from tacos_framework.settings.yaml_reader import read_yaml_draft

_WITH_METADATA: Mapping[str, Any] = {"scenario": Scenarios, "exposure": ExposureControl}
"""Sections whose annotation says more than its type, of which a field keeps the type alone."""


def parse_recipe(text: str, *, name: str = "recipe") -> tuple[Recipe, list[Fault]]:
    """A recipe from text, and the faults of its form; see `read_any_recipe`."""
    return recipe_from(read_yaml_draft(text, name=name))


def recipe_from(
    document: Document,
    sets: Mapping[str, Any] = MappingProxyType({}),
    effects: Sequence[Mapping[str, Any]] = (),
    places: Mapping[tuple[str | int, ...], str] = MappingProxyType({}),
) -> tuple[Recipe, list[Fault]]:
    """As `parse_recipe`, from a YAML document; see `with_overrides`."""
    data = document.data
    if not isinstance(data, dict):
        form = Fault(document.where(()), "a recipe is a mapping", "keys such as name, rig, design, nodes")
        raise UserError([*document.faults, form])
    sets = {_of_the_only_node(data, key): value for key, value in sets.items()}
    document, faults = with_overrides(document, sets, effects, places)
    faults += document.faults
    sections: dict[str, Any] = {}
    if "tacos" not in data:
        faults.append(
            Fault(document.where(()), "'tacos' is missing", f"tacos: {FORMAT}", "Add it as the first line.")
        )
    for key in data:
        if key not in Recipe.model_fields:
            remedy = did_you_mean(str(key), Recipe.model_fields)
            faults.append(Fault(document.where((key,)), f"unknown key {key!r}", "", remedy))
    for key, field in Recipe.model_fields.items():
        if key not in data:
            if field.is_required():
                faults.append(
                    Fault(document.where(()), f"{key!r} is missing", "", f"Add it: {field.description}")
                )
            continue
        value, found = _section(document, key, _annotation(key), data[key])
        faults += found
        if value is not None:
            sections[key] = value
    recipe = _draft(sections)
    misread = data.keys() - sections.keys()
    clashes = [clash for clash in recipe.clashes() if misread.isdisjoint(re.findall(r"\w+", clash))]
    faults += [clash_fault(clash, data, document.where) for clash in clashes]
    if not faults:
        _, faults, _ = check(Recipe, data, document.where)
    recipe._document = document
    return recipe, document.without_echoes(faults)


def _of_the_only_node(data: Mapping[str, Any], key: str) -> str:
    """A key of ``--set`` that is no section, and that one node alone gives, is the setting of that node.

    >>> _of_the_only_node({"nodes": {"world": {"use": "scene.recorded", "recording": ""}}}, "recording")
    'nodes.world.recording'
    """
    nodes = data.get("nodes")
    if key in Recipe.model_fields or not isinstance(nodes, Mapping):
        return key
    owners = [
        name for name, node in nodes.items() if isinstance(node, Mapping) and key in node and key != "use"
    ]
    return f"nodes.{owners[0]}.{key}" if len(owners) == 1 else key


def _annotation(key: str) -> Any:
    """The type of a section with its bounds, such as that of a seed, and with what it means."""
    field = Recipe.model_fields[key]
    return _WITH_METADATA.get(key, Annotated[field.annotation, field])


def _section(document: Document, key: str, annotation: Any, raw: Any) -> tuple[Any, list[Fault]]:
    """Check one section; where items of it are wrong, keep the others so that they are checked further."""

    def where(path: Sequence[str | int]) -> str:
        return document.where((key, *path))

    value, faults, paths = check(annotation, raw, where, key)
    if key == "design" and isinstance(raw, dict):
        plain = [len(path) == 1 and not isinstance(raw.get(path[0]), dict) for path in paths]
        faults = [
            _no_entry(fault) if is_plain else fault for fault, is_plain in zip(faults, plain, strict=True)
        ]
    if faults and isinstance(raw, dict) and key in ("nodes", "design", "constraints"):
        bad = {path[0] for path in paths if path}
        value, _, _ = check(annotation, {name: item for name, item in raw.items() if name not in bad}, where)
    return value, faults


def _no_entry(fault: Fault) -> Fault:
    """Advice about a design variable that is given a plain value."""
    return replace(
        fault,
        expected="an entry such as {between: [1, 2]} or {choose: [a, b]}",
        remedy="To fix it, move it under rig:, or among the settings of its node or effect.",
    )


def _draft(sections: dict[str, Any]) -> Recipe:
    """A recipe of the sections that were understood; the required ones that were not are empty."""
    empty: dict[str, Any] = {
        "name": "",
        "rig": None,
        "design": {},
        "nodes": {},
        "fitness": (),
        "optimizer": None,
    }
    return Recipe.model_construct(**{**empty, **sections})
