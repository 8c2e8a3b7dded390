"""Design cameras for vision tasks in simulation, as a pipeline of plugins."""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_HOMES = {
    "Component": "components",
    "CandidateFailed": "errors",
    "Fault": "errors",
    "Plugins": "plugins",
    "ProcedureRecipe": "procedure",
    "Recipe": "recipe",
    "Settings": "settings",
    "UserError": "errors",
    "hookimpl": "hookspecs",
    "load_recipe": "loading",
    "run": "running",
    "setting": "settings",
}

__all__ = ["__version__", *_HOMES]  # noqa: PLE0604 - names that are imported on first use


def __getattr__(name: str) -> Any:
    """Import public names on first use, so that importing the package costs nothing."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
