"""Settings of components and recipes: declared once, checked strictly, read from and written as YAML."""

from __future__ import annotations

from tacos_framework.settings.checking import KeyPath, check
from tacos_framework.settings.settings import (
    Settings,
    also_called,
    averaging_of,
    includes_pedestal,
    path_settings,
    paths_in,
    period_of,
    physical,
    physical_settings,
    setting,
    unit_of,
    with_paths_from,
)

__all__ = [
    "KeyPath",
    "Settings",
    "also_called",
    "averaging_of",
    "check",
    "includes_pedestal",
    "path_settings",
    "paths_in",
    "period_of",
    "physical",
    "physical_settings",
    "setting",
    "unit_of",
    "with_paths_from",
]
