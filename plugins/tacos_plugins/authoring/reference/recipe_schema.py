"""JSON Schema of recipes, for editors: what the installed plugins take, told apart by ``use:``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema

from tacos_framework import (
    FIXED,
    NODE_KINDS,
    SHARED_KEYS,
    EffectUse,
    Plugins,
    Recipe,
    UserError,
    camera_names,
    catalog_names,
    learns,
    signature_of,
    type_name,
)

DIALECT = "https://json-schema.org/draft/2020-12/schema"
SETTING_OF_A_NODE = r"^[a-z][a-z0-9_]*\.[A-Za-z0-9_.-]+$"
"""A name under ``design:`` that means a setting of a node, of an effect, of the exposure control, or of
the scenario."""

COLUMN_OF_A_PART = r"^[a-z][a-z0-9_]*\.[a-z][A-Za-z0-9_]*$"
"""A name under ``constraints:`` that means a column of the part that a variable chooses."""

Schema = dict[str, Any]


@dataclass(frozen=True)
class RecipeSchema:
    """A schema, and why some components are not described in it."""

    schema: Schema
    """JSON Schema, draft 2020-12, as plain data."""
    undescribed: Mapping[str, str] = field(default_factory=dict)
    """Component -> reason; their settings are not checked."""


def recipe_schema(plugins: Plugins) -> RecipeSchema:
    """The schema of all recipes that the plugins allow.

    It refuses what can be told from one recipe's form alone: unknown keys and components, values of the
    wrong type or out of bounds, ports that are not wired. Whether names refer to something is left to
    ``tacos-run --check``.

    >>> schema = recipe_schema(Plugins.discover()).schema
    >>> schema["$defs"]["rig.monocular"]["properties"]["focal_length_mm"]["description"]
    'Focal length of a lens yet to be found, instead of a lens. [mm]'
    """
    study = _model_schema(Recipe, "#/$defs/{model}")
    definitions: Schema = study.pop("$defs")
    undescribed: dict[str, str] = {}
    by_kind: dict[str, dict[str, str]] = {}
    designs: list[Schema] = []
    for registered in plugins:
        component = registered.component
        by_kind.setdefault(component.kind, {})[component.use] = component.summary
        try:
            cls = plugins.resolve(component.use)
            described = _component(cls, component.kind, component.use, component.summary)
        except UserError as error:
            undescribed[component.use] = error.faults[0].what
        except Exception as error:  # noqa: BLE001 - a stranger's code must not spoil the schema of others
            undescribed[component.use] = f"its import failed: {type(error).__name__}: {error}"
        if component.use in undescribed:
            described = {"type": "object", "description": component.summary}
        definitions[component.use] = described
        if component.kind == "effect":
            definitions[_node(component.use)] = described
            definitions[component.use] = _listed_effect(described)
        if component.use in undescribed:
            continue
        if component.kind == "rig":
            designs.append(_designs_of(cls, component.use))
    properties = study["properties"]
    properties["rig"] = _one_of(by_kind, "rig")
    properties["nodes"]["additionalProperties"] = _one_of(by_kind, *NODE_KINDS)
    properties["nodes"].pop("patternProperties", None)
    properties["nodes"]["propertyNames"] = {"pattern": "^[a-z][a-z0-9_]*$"}
    properties["effects"] = {**properties["effects"], "items": _one_of(by_kind, "effect", listed=True)}
    properties["optimizer"] = _one_of(by_kind, "optimizer")
    properties["exposure"] = {"anyOf": [{"const": FIXED}, _one_of(by_kind, "control")]}
    properties["executor"] = _one_of(by_kind, "executor")
    definitions["Design"] = properties["design"]["additionalProperties"]
    properties["design"]["additionalProperties"] = {"$ref": "#/$defs/Design"}
    _suggest(definitions["FromCatalog"]["properties"]["from"], catalog_names())
    _suggest(definitions["Compare"]["properties"]["cameras"]["items"], camera_names())
    study["required"] = ["tacos", *study["required"]]
    study["allOf"] = designs
    definitions["study"] = study
    definitions["procedure"] = _procedures(by_kind.get("procedure", {}), definitions, properties)
    schema = {
        "$schema": DIALECT,
        "title": "Recipe of tacos-framework",
        "type": "object",
        "if": {"required": ["use"]},
        "then": {"$ref": "#/$defs/procedure"},
        "else": {"$ref": "#/$defs/study"},
        "$defs": definitions,
    }
    return RecipeSchema(schema, undescribed)


def _component(cls: type[Any], kind: str, use: str, summary: str) -> Schema:
    """The keys of a component in a recipe: ``use``, wiring, settings."""
    place = f"#/$defs/{use}/$defs/{{model}}"
    settings = _model_schema(cls.Config, place)
    own = {"use": {"const": use, "description": summary}}
    required = ["use", *settings.get("required", [])]
    if kind == "effect":
        own["cameras"] = _property_of(EffectUse, "cameras")
    if kind in NODE_KINDS:
        ports = signature_of(cls, kind).inputs
        if ports:
            own["in"] = _wiring(ports)
            required.append("in")
    if kind == "task" and learns(cls):
        own["train"] = {"$ref": "#/$defs/Train"}
    if kind == "rig":  # its variables may be fixed here, or designed
        variables = _model_schema(cls.Variables, place)
        settings["properties"] = {**settings.get("properties", {}), **variables.get("properties", {})}
        settings["$defs"] = {**settings.get("$defs", {}), **variables.get("$defs", {})}
    return {
        **settings,
        "title": use,
        "description": summary,
        "properties": {**own, **settings.get("properties", {})},
        "required": required,
    }


def _wiring(ports: Mapping[str, type[Any]]) -> Schema:
    return {
        "type": "object",
        "description": "Which node feeds each port.",
        "properties": {
            port: {"type": "string", "description": f"The node that gives the {type_name(taken)}."}
            for port, taken in ports.items()
        },
        "required": list(ports),
        "additionalProperties": False,
    }


def _listed_effect(node: Schema) -> Schema:
    """An effect as it stands under ``effects:``, from what it is as a node: named, and not wired."""
    if "properties" not in node:
        return node
    properties = {key: value for key, value in node["properties"].items() if key != "in"}
    return {
        **node,
        "properties": {**properties, "name": _property_of(EffectUse, "name")},
        "required": [key for key in node["required"] if key != "in"],
    }


def _property_of(model: type[BaseModel], name: str) -> Schema:
    found: Schema = _model_schema(model, "{model}")["properties"][name]
    return found


def _node(use: str) -> str:
    """The definition of an effect as a node."""
    return f"{use}.node"


def _one_of(by_kind: Mapping[str, Mapping[str, str]], *kinds: str, listed: bool = False) -> Schema:
    """Any component of some kinds; its name decides which settings it takes."""
    summaries = {use: summary for kind in kinds for use, summary in by_kind.get(kind, {}).items()}
    chosen: Schema = {
        "type": "object",
        "required": ["use"],
        "properties": {"use": {"enum": list(summaries), "enumDescriptions": list(summaries.values())}},
    }
    if summaries:  # `allOf` must not be empty
        names = {use: _node(use) if use.startswith("effect.") and not listed else use for use in summaries}
        chosen["allOf"] = [_where_use_is(use, {"$ref": f"#/$defs/{name}"}) for use, name in names.items()]
    return chosen


def _where_use_is(use: str, then: Schema) -> Schema:
    return {"if": {"required": ["use"], "properties": {"use": {"const": use}}}, "then": then}


def _designs_of(cls: type[Any], use: str) -> Schema:
    """The variables and quantities of one rig."""
    variables = {
        name: {"$ref": "#/$defs/Design", "description": described.get("description", "")}
        for name, described in _model_schema(cls.Variables, "{model}")["properties"].items()
    }
    quantities = {
        name: {"$ref": "#/$defs/Bounds", "description": f"[{unit}]"}
        for name, unit in cls.derived_quantities.items()
    }
    own_or_of_a_part = {"anyOf": [{"enum": list(quantities)}, {"pattern": COLUMN_OF_A_PART}]}
    own_or_of_a_node = {"anyOf": [{"enum": list(variables)}, {"pattern": SETTING_OF_A_NODE}]}
    then = {
        "design": {"properties": variables, "propertyNames": own_or_of_a_node},
        "constraints": {"properties": quantities, "propertyNames": own_or_of_a_part},
    }
    condition = {"rig": _where_use_is(use, {})["if"]}
    return {"if": {"required": ["rig"], "properties": condition}, "then": {"properties": then}}


def _procedures(summaries: Mapping[str, str], definitions: Schema, shared: Mapping[str, Schema]) -> Schema:
    """Recipes of procedures; the settings stand at the top, beside the keys that all have."""
    headings = {key: shared[key] for key in SHARED_KEYS}
    for use in summaries:
        own = definitions[use]
        if "properties" in own:
            own["properties"] = {**headings, **own["properties"]}
            own["required"] = ["tacos", "name", *own["required"]]
    return _one_of({"procedure": summaries}, "procedure")


def _suggest(schema: Schema, names: Iterable[str]) -> None:
    """Let editors offer known names where any text may stand."""
    schema["anyOf"] = [{"enum": list(names)}, {"type": schema.pop("type")}]


class _WithoutTitles(GenerateJsonSchema):
    """Leaves out titles, which only repeat the names of fields."""

    def field_title_should_be_set(self, schema: Any) -> bool:
        return False


def _model_schema(model: type[BaseModel], references: str) -> Schema:
    """The schema of a model, with units in the descriptions."""
    schema = model.model_json_schema(
        by_alias=True, ref_template=references, schema_generator=_WithoutTitles, mode="validation"
    )
    for described in (schema, *schema.get("$defs", {}).values()):
        for setting in described.get("properties", {}).values():
            unit = setting.get("unit", "1")
            if unit != "1" and "description" in setting:
                setting["description"] = f"{setting['description']} [{unit}]"
    return schema
