"""Plain data checked against settings, and how the complaints reach the user."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from types import UnionType
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, Discriminator, Tag, TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from tacos_framework.errors import Fault, did_you_mean
from tacos_framework.settings.settings import also_called

Path = tuple[str | int, ...]
"""Keys and indices from the top of a recipe to a value."""

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


_IN_YAML = {
    "a valid array": "a list, as in [a, b]",
    "an object": "keys with their values, as in {key: value}",
}
"""What pydantic expects, in the words of whoever writes YAML and not JSON."""


def _fault(details: Mapping[str, Any], kind: Any, where: Callable[[Path], str], top: str) -> Fault:
    path = _without_tags(details["loc"])
    name = ".".join(map(str, (top, *path) if top else path))
    model, field = _owner(kind, details["loc"])
    if details["type"] == "extra_forbidden":
        known = [f.alias or key for key, f in model.model_fields.items()] if model is not None else []
        called = also_called(model) if model is not None else {}
        return Fault(where(path), f"unknown key {name!r}", "", did_you_mean(str(path[-1]), known, called))
    if details["type"] == "missing":
        return Fault(where(path), f"{name!r} is missing", _help(field), f"Add {path[-1]!r}.")
    if details["type"] == "value_error" and isinstance(details["input"], dict):  # settings that clash
        clash = details["msg"].removeprefix("Value error, ")
        return Fault(where((*path, *_first_named(clash, details["input"]))), clash, "", "Change one of them.")
    given = json.dumps(details["input"], default=str)
    given = given if len(given) <= 60 else f"{given[:57]}..."
    expected = details["msg"].removeprefix("Input should be ").removeprefix("Value error, ")
    expected = _IN_YAML.get(expected, expected)
    meaning = f" ({help})" if (help := _help(field)) else ""
    return Fault(where(path), f"{name or 'value'} is {given}", f"{expected}{meaning}", "Correct the value.")


def _first_named(sentence: str, given: Mapping[str, Any]) -> Path:
    """The key that a complaint about several names first, among those that were given."""
    words = re.findall(r"\w+", sentence)
    return next(((word,) for word in words if word in given), ())


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
