"""Processing of files in a camera: a list of effects with their settings, written out or named."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema

from tacos_framework.errors import UserError
from tacos_framework.packaged_resources import find_file, shipped_folder
from tacos_framework.settings.yaml_reader import read_yaml


def written_out(given: Any) -> Any:
    """A pipeline that is named, or begins from a named one (``from:``), as its effects and settings.

    >>> list(written_out("coded")), list(written_out({"from": "coded", "jpeg": {"quality": 90}}))
    (['demosaic', 'tone-curve'], ['demosaic', 'tone-curve', 'jpeg'])
    """
    if isinstance(given, str):
        return _named(given)
    if isinstance(given, Mapping) and isinstance(first := given.get("from"), str):
        return _named(first) | {name: settings for name, settings in given.items() if name != "from"}
    return given


def _named(name: str) -> Any:
    try:
        file = find_file(name, shipped_folder("catalogs") / "pipelines", noun="pipeline")
    except UserError as error:
        (fault,) = error.faults
        raise ValueError(f"{fault.what}; {fault.remedy or fault.expected}") from error
    return read_yaml(file).data


_SCHEMA = {
    "anyOf": [{"type": "string"}, {"type": "object", "additionalProperties": {"type": ["object", "string"]}}]
}

Pipeline = Annotated[dict[str, dict[str, Any]], BeforeValidator(written_out), WithJsonSchema(_SCHEMA)]
"""Effects without their kind, each with its settings: ``{"jpeg": {"quality": 90}}``."""
