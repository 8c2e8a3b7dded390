"""Cameras and data in the formats of other programs, as a plugin: importing it is light."""

from __future__ import annotations

from tacos_export.commands import commands
from tacos_framework import Command, hookimpl


@hookimpl
def tacos_commands() -> list[Command]:
    return commands()
