"""Optional members of components, which stand with their defaults in a base class for each kind."""

from __future__ import annotations

from typing import Any


def optional(component: object, base: type[Any], name: str) -> Any:
    """An optional member of a component, or what the base class of its kind has in its place.

    Components may inherit the base class and need not.

    Raises `AttributeError` when the base class has no such member.
    """
    return getattr(component, name, getattr(base, name))
