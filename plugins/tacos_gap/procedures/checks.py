"""Faults of the settings of a diagnosis, all at once and before any work."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tacos_framework import Fault, Plugins, UserError
from tacos_gap.captures import read_captures
from tacos_gap.simulation.bench import recipe_renderer


def check_all(*checks: Callable[[], Any]) -> None:
    faults: list[Fault] = []
    for each in checks:
        try:
            each()
        except UserError as error:
            faults += [fault for fault in error.faults if fault not in faults]
    if faults:
        raise UserError(faults)


def check_captures(folder: str, plugins: Plugins) -> None:
    """Read a folder of captures, each of its files included: a run then begins with all of it.

    Raises UserError with every fault of the folder.
    """
    read_captures(folder, recipe_renderer(plugins))
