"""Settings of components and recipes: declared once, checked strictly, read from and written as YAML."""

from __future__ import annotations

from tacos_framework.settings.checking import Path, check
from tacos_framework.settings.settings import Settings, setting, with_paths_from

__all__ = ["Path", "Settings", "check", "setting", "with_paths_from"]
