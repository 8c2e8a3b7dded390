"""The base of every component's ``Config``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, JsonValue


class Settings(BaseModel):
    """Settings of a component: frozen, unknown keys refused, no NaN.

    Each field is declared with :func:`setting`, so that checks, error messages, the settings reference
    and the JSON Schema for editors come from one place.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True)


def setting(default: Any = ..., *, help: str, unit: str = "1", is_path: bool = False, **bounds: Any) -> Any:
    """Declare one setting.

    Parameters
    ----------
    default
        The default value; leave out for a setting the user must give.
    help
        One sentence that says what the setting does.
    unit
        Its unit (``"m"``, ``"deg"``); ``"1"`` for a plain number, a name or a switch.
    is_path
        Whether text given for it may be a path; a recipe's relative paths start from its own folder.
    bounds
        pydantic's ``gt``, ``ge``, ``lt``, ``le``, ``min_length``, ``max_length``, ``alias``.
    """
    extra: dict[str, JsonValue] = {"unit": unit, "path": True} if is_path else {"unit": unit}
    return Field(default, description=help, json_schema_extra=extra, **bounds)


def with_paths_from(folder: Path, config: type[Settings], settings: Mapping[str, Any]) -> dict[str, Any]:
    """The settings, with relative paths to what exists below `folder` made to start there."""
    found = dict(settings)
    for name, field in config.model_fields.items():
        extra = field.json_schema_extra
        value = settings.get(name)
        if isinstance(extra, dict) and extra.get("path") and isinstance(value, str) and value:
            path = folder / value
            if path.exists():
                found[name] = str(path)
    return found
