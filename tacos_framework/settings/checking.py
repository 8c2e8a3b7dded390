"""Plain data checked against settings, and how the complaints reach the user."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import UnionType
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, Discriminator, Tag, TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from tacos_framework.errors import Fault, did_you_mean
from tacos_framework.settings.settings import Settings, also_called
from tacos_framework.settings.wording import expected_by

KeyPath = tuple[str | int, ...]
"""Keys and indices from the top of a recipe to a value."""

Checked = TypeVar("Checked")


def check(
    kind: type[Checked] | Any, raw: Any, where: Callable[[KeyPath], str], name: str = ""
) -> tuple[Checked | None, list[Fault], list[KeyPath]]:
    """Validate plain data strictly against a Settings class or any type.

    Strictly means: text is not taken for a number, a number not for a switch; lists do stand for tuples.

    - `kind`: a `Settings` class, or any type pydantic understands.
    - `raw`: data as YAML gives it.
    - `where`: turns the path of a value below `raw` into file, line and column.
    - `name`: what `raw` is called in messages, when it is not the top.

    Returns: the checked value (None when there are faults), all faults, and the paths of the faulty values.
    """
    adapter = TypeAdapter(kind)
    try:
        return adapter.validate_json(json.dumps(raw), strict=True), [], []
    except ValidationError as error:
        complaints: dict[KeyPath, list[Mapping[str, Any]]] = {}
        for details in error.errors(include_url=False):
            complaints.setdefault(_place(kind, details).path, []).append(details)
        paths = [path for path in complaints if not _is_told_below(path, complaints)]
        return None, [_fault(complaints[path], kind, where, name) for path in paths], paths


def _is_told_below(path: KeyPath, paths: Iterable[KeyPath]) -> bool:
    """True if an entry is wrong, not the presence of entries: another type may be allowed too."""
    return any(len(other) > len(path) and other[: len(path)] == path for other in paths)


def _fault(
    complaints: Sequence[Mapping[str, Any]], kind: Any, where: Callable[[KeyPath], str], top: str
) -> Fault:
    """The fault of one value; there is a complaint for each type that it might have had."""
    details = complaints[0]
    place = _place(kind, details)
    path, model, keys = place.path, place.model, (top, *place.path) if top else place.path
    name = ".".join(map(str, keys))
    if details["type"] == "extra_forbidden":
        known = [f.alias or key for key, f in model.model_fields.items()] if model is not None else []
        called = also_called(model) if model is not None else {}
        retired = model.retired_keys if model is not None and issubclass(model, Settings) else {}
        remedy = retired.get(str(path[-1])) or did_you_mean(str(path[-1]), known, called)
        return Fault(where(path), f"unknown key {name!r}", "", remedy)
    if details["type"] == "missing" and not place.is_too_short:
        return Fault(where(path), f"{name!r} is missing", _help(place.field), f"Add {path[-1]!r}.")
    if details["type"] == "value_error" and isinstance(details["input"], dict):  # settings that clash
        clash = details["msg"].removeprefix("Value error, ")
        return clash_fault(clash, details["input"], lambda below: where((*path, *below)))
    given = json.dumps(details["input"], default=str)
    given = given if len(given) <= 60 else f"{given[:57]}..."
    wanted = ", or ".join(dict.fromkeys(_expected(kind, each) for each in complaints))
    if details["loc"][-1:] == ("[key]",):
        owner = ".".join(map(str, keys[:-1])) or "it"
        return Fault(where(path), f"{owner} has a key {given}", wanted, "Rename it.")
    meaning = f" ({help})" if (help := _help(place.field)) else ""
    remedy = details.get("ctx", {}).get("remedy", "Correct the value.")
    return Fault(where(path), f"{name or 'value'} is {given}", f"{wanted}{meaning}", remedy)


def _expected(kind: Any, complaint: Mapping[str, Any]) -> str:
    place = _place(kind, complaint)
    return f"{len(get_args(place.kind))} entries" if place.is_too_short else expected_by(complaint)


def clash_fault(sentence: str, given: Mapping[str, Any], where: Callable[[KeyPath], str]) -> Fault:
    """The fault of several settings at once, at the first of them that the sentence names."""
    return Fault(where(_first_named(sentence, given)), sentence, "", "Change one of them.")


def _first_named(sentence: str, given: Mapping[str, Any]) -> KeyPath:
    """The key that a complaint about several names first, among those that were given."""
    words = re.findall(r"\w+", sentence)
    return next(((word,) for word in words if word in given), ())


def _help(field: FieldInfo | None) -> str:
    """Help and unit of a field."""
    if field is None or not field.description:
        return ""
    extra = field.json_schema_extra
    unit = extra.get("unit", "1") if isinstance(extra, dict) else "1"
    meaning = field.description.rstrip(".")
    return meaning if unit == "1" else f"{meaning} [{unit}]"


@dataclass(frozen=True)
class _Place:
    """Position of pydantic's complaint: the path in the file, the class and field there, and their type."""

    path: KeyPath
    model: type[BaseModel] | None
    field: FieldInfo | None
    kind: Any
    is_too_short: bool = False


def _place(kind: Any, complaint: Mapping[str, Any]) -> _Place:
    """The place of a complaint; of an entry that a list lacks it is the list."""
    steps = complaint["loc"]
    if complaint["type"] == "missing" and isinstance(steps[-1], int):
        return replace(_at(kind, steps[:-1]), is_too_short=True)
    return _at(kind, steps)


def _at(kind: Any, steps: KeyPath) -> _Place:
    """The field at a path of pydantic's; such a path also names members of unions, which no file has."""
    model: type[BaseModel] | None = None
    field = next((note for note in get_args(kind)[1:] if isinstance(note, FieldInfo)), None)
    path: list[str | int] = []
    for step in steps:
        kind = _plain(kind)
        members = get_args(kind)
        if str(step).startswith("<"):
            kind = next((member for member in members if Tag(str(step)) in get_args(member)), None)
        elif get_origin(kind) in (Union, UnionType):
            kind = next((member for member in members if _name(member) == str(step).partition("[")[0]), None)
        elif step != "[key]":
            path.append(step)
            if isinstance(kind, type) and issubclass(kind, BaseModel):
                model, fields = kind, kind.model_fields
                field = next((f for name, f in fields.items() if step in (name, f.alias)), None)
                kind = field.annotation if field is not None else None
            else:
                model, field = None, None
                kind = members[-1 if get_origin(kind) is dict else 0] if members else None
    return _Place(tuple(path), model, field, _plain(kind))


def _name(kind: Any) -> str:
    """Name of a union's member in pydantic, without the brackets behind it."""
    return str(getattr(get_origin(kind) or kind, "__name__", ""))


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
