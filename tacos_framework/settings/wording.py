"""Expectations of pydantic in the words of people who write YAML and know neither JSON nor Python."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_A_LIST = "a list, as in [a, b]"
_KEYS = "keys with their values, as in {key: value}"
_EXPECTED = {
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "int_parsing": "a whole number",
    "float_type": "a number",
    "float_parsing": "a number",
    "finite_number": "a finite number",
    "string_type": "text",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
    "none_required": "nothing",
    "list_type": _A_LIST,
    "tuple_type": _A_LIST,
    "dict_type": _KEYS,
    "model_type": _KEYS,
    "model_attributes_type": _KEYS,
}
"""By the type of pydantic's complaint."""

_LETTERS = "lower-case letters, digits and _, beginning with a letter"
_FORMS = {r"^[a-z][a-z0-9_]*$": _LETTERS, r"^[a-z][a-z0-9_-]*$": _LETTERS.replace("and _", "_ and -")}
"""Patterns that settings have, in words."""


def expected_by(complaint: Mapping[str, Any]) -> str:
    """The expectation behind a complaint of pydantic's, as `ValidationError.errors` gives it.

    >>> expected_by({"type": "int_from_float", "msg": "Input should be a valid integer, got ..."})
    'a whole number'
    >>> too_long = {"field_type": "Tuple", "max_length": 2, "actual_length": 3}
    >>> expected_by({"type": "too_long", "ctx": too_long, "msg": "Tuple should have at most 2 items ..."})
    'at most 2 entries'
    """
    kind, context = complaint["type"], complaint.get("ctx", {})
    match kind:
        case "too_short" | "string_too_short":
            return f"at least {_counted(context['min_length'], text=kind.startswith('string'))}"
        case "too_long" | "string_too_long":
            return f"at most {_counted(context['max_length'], text=kind.startswith('string'))}"
        case "string_pattern_mismatch":
            return _FORMS.get(context["pattern"], f"text of the form {context['pattern']}")
    said = str(complaint["msg"]).removeprefix("Input should be ").removeprefix("Value error, ")
    return _EXPECTED.get(kind, said)


def _counted(count: int, *, text: bool) -> str:
    one, many = ("character", "characters") if text else ("entry", "entries")
    return f"{count} {one if count == 1 else many}"
