"""Plugins: discovered by entry points, their failures kept, their components resolved and checked."""

from __future__ import annotations

from tacos_framework.plugins.discovery import PluginFailure, Plugins, Registered, contract_faults
from tacos_framework.plugins.guarded import Culprit, calling, culprit_of

__all__ = [
    "Culprit",
    "PluginFailure",
    "Plugins",
    "Registered",
    "calling",
    "contract_faults",
    "culprit_of",
]
