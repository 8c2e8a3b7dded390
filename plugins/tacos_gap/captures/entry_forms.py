"""Entries that take several forms: which one is meant is told by what YAML gave, not by trial of each."""

from __future__ import annotations

from typing import Any

from pydantic import Discriminator

from tacos_framework import Settings

_FORMS: dict[str, tuple[type, ...]] = {
    "<number>": (int, float),
    "<text>": (str,),
    "<list>": (list, tuple),
    "<keys>": (dict, Settings),
}


def told_apart(expected: str, *, length: int | None = None) -> Discriminator:
    """Tells the members of a union apart, so that a wrong entry is one fault and not one for each member.

    `expected`: says all its forms; what has none of them, or is empty, is refused with it. `length`: of its
    lists; None for any.

    Members are tagged ``<number>``, ``<text>``, ``<list>`` and ``<keys>``.
    """

    def form(raw: Any) -> str | None:
        if raw in ("", [], ()) or (isinstance(raw, list | tuple) and length not in (None, len(raw))):
            return None
        return next((tag for tag, types in _FORMS.items() if isinstance(raw, types)), None)

    return Discriminator(form, custom_error_type="form", custom_error_message=expected)
