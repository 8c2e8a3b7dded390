"""``tacos export``."""

from __future__ import annotations

from tacos_framework.components import Command


def commands() -> list[Command]:
    """The commands; importing this is light."""
    return []
