"""Plugins: discovered by entry points, their failures kept, their components resolved and checked."""

from __future__ import annotations

from tacos_framework.plugins.discovery import Plugins
from tacos_framework.plugins.failures import PluginFailure
from tacos_framework.plugins.guarded import Culprit, calling, culprit_of
from tacos_framework.plugins.observers import Observer, Observers
from tacos_framework.plugins.registry import Registered

__all__ = [
    "Culprit",
    "Observer",
    "Observers",
    "PluginFailure",
    "Plugins",
    "Registered",
    "calling",
    "culprit_of",
]
