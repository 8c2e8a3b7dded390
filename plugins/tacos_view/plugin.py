"""A look at scenes, cameras, effects and catalogs, as a plugin: importing it is light."""

from __future__ import annotations

from tacos_framework import Command, hookimpl
from tacos_view.commands import commands


@hookimpl
def tacos_commands() -> list[Command]:
    return commands()
