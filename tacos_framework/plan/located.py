"""The resolved recipe of a plan, which can be read from any folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tacos_framework.packaged_resources import is_shipped_name
from tacos_framework.plan.plan import Plan
from tacos_framework.settings import Settings, path_settings

Keys = tuple[str | int, ...]


def located_recipe(plan: Plan) -> dict[str, Any]:
    """The plan's recipe as plain data, every default filled in, files named by absolute paths.

    A relative path starts at the recipe's own folder, and the data are kept in another. Names of what is
    shipped stay as they are.
    """
    parts = [*plan.parts.values(), plan.executor]
    return _located(plan.recipe.as_data(), (), plan, {part.use: part.cls.Config for part in parts})


def _located(data: Mapping[str, Any], keys: Keys, plan: Plan, configs: Mapping[str, type[Settings]]) -> Any:
    """The data below some keys of the recipe."""
    if isinstance(data, Mapping):
        paths = _keys_of_paths(data, keys, configs)
        return {
            key: _absolute(value, plan.recipe.folder_of((*keys, key)))
            if key in paths and isinstance(value, str) and value
            else _located(value, (*keys, key), plan, configs)
            for key, value in data.items()
        }
    if isinstance(data, list):
        return [_located(value, (*keys, i), plan, configs) for i, value in enumerate(data)]
    return data


def _keys_of_paths(
    data: Mapping[str, Any], keys: Keys, configs: Mapping[str, type[Settings]]
) -> Sequence[str]:
    """The keys of a section whose values may be paths."""
    if keys == ("compare",) or keys[:1] == ("design",):
        key = "catalog" if keys == ("compare",) else "from"
        return () if is_shipped_name(str(data.get(key))) else (key,)
    config = configs.get(str(data.get("use")))
    return () if config is None else path_settings(config)


def _absolute(value: str, folder: Path | None) -> str:
    path = (folder or Path()) / value
    return str(path.absolute()) if path.exists() else value
