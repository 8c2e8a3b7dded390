"""The base of every component's ``Config``, and how its complaints reach the user."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path as FilePath
from types import UnionType
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Discriminator, Field, JsonValue, Tag, TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from tacos_framework.errors import Fault, did_you_mean

Path = tuple[str | int, ...]
"""Keys and indices from the top of a recipe to a value."""


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


def with_paths_from(folder: FilePath, config: type[Settings], settings: Mapping[str, Any]) -> dict[str, Any]:
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


Checked = TypeVar("Checked")


def check(
    kind: type[Checked] | Any,
    raw: Any,
    where: Callable[[Path], str],
    name: str = "",
) -> tuple[Checked | None, list[Fault], list[Path]]:
    """Validate plain data strictly against a Settings class or any type.

    Strictly means: text is not taken for a number, a number not for a switch; lists do stand for tuples.

    Parameters
    ----------
    kind
        A `Settings` class, or any type pydantic understands.
    raw
        Data as YAML gives it.
    where
        Turns the path of a value below `raw` into file, line and column.
    name
        What `raw` is called in messages, when it is not the top.

    Returns
    -------
    The checked value (None when there are faults), all faults, and the paths of the faulty values.
    """
    adapter = TypeAdapter(kind)
    try:
        return adapter.validate_json(json.dumps(raw), strict=True), [], []
    except ValidationError as error:
        faults = [_fault(details, kind, where, name) for details in error.errors(include_url=False)]
        return None, faults, [_without_tags(details["loc"]) for details in error.errors(include_url=False)]


def _fault(details: Mapping[str, Any], kind: Any, where: Callable[[Path], str], top: str) -> Fault:
    path = _without_tags(details["loc"])
    name = ".".join(map(str, (top, *path) if top else path))
    model, field = _owner(kind, details["loc"])
    if details["type"] == "extra_forbidden":
        known = [f.alias or key for key, f in model.model_fields.items()] if model is not None else []
        return Fault(where(path), f"unknown key {name!r}", "", did_you_mean(str(path[-1]), known))
    if details["type"] == "missing":
        return Fault(where(path), f"{name!r} is missing", _help(field), f"Add {path[-1]!r}.")
    given = json.dumps(details["input"], default=str)
    given = given if len(given) <= 60 else f"{given[:57]}..."
    expected = details["msg"].removeprefix("Input should be ").removeprefix("Value error, ")
    meaning = f" ({help})" if (help := _help(field)) else ""
    return Fault(where(path), f"{name or 'value'} is {given}", f"{expected}{meaning}", "Correct the value.")


def _help(field: FieldInfo | None) -> str:
    """What a field means: its help and unit."""
    if field is None or not field.description:
        return ""
    extra = field.json_schema_extra
    unit = extra.get("unit", "1") if isinstance(extra, dict) else "1"
    meaning = field.description.rstrip(".")
    return meaning if unit == "1" else f"{meaning} [{unit}]"


def _without_tags(path: Path) -> Path:
    """Pydantic puts the tag of a union's member into a path; a file has no such key."""
    return tuple(step for step in path if not str(step).startswith("<"))


def _owner(kind: Any, path: Path) -> tuple[type[BaseModel] | None, FieldInfo | None]:
    """The Settings class that holds the last key of `path` and its field, as far as they can be told."""
    model: type[BaseModel] | None = None
    field: FieldInfo | None = None
    for step in path:
        kind = _plain(kind)
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            model = kind
            fields = model.model_fields
            field = next((f for name, f in fields.items() if step in (name, f.alias)), None)
            kind = field.annotation if field is not None else None
        elif str(step).startswith("<"):
            kind = next((member for member in get_args(kind) if Tag(str(step)) in get_args(member)), None)
        else:
            model, field = None, None
            members = get_args(kind)
            kind = members[-1 if get_origin(kind) is dict else 0] if members else None
    return model, field


def _plain(kind: Any) -> Any:
    """A type without ``Annotated`` and without ``| None``."""
    if get_origin(kind) is Annotated and not any(
        isinstance(note, Discriminator) for note in get_args(kind)[1:]
    ):
        return _plain(get_args(kind)[0])
    if get_origin(kind) is Annotated:
        return get_args(kind)[0]
    if get_origin(kind) in (Union, UnionType):
        members = [member for member in get_args(kind) if member is not type(None)]
        return _plain(members[0]) if len(members) == 1 else kind
    return kind
