"""Plugins: discovered by entry points, their failures kept, their components resolved and checked."""

from __future__ import annotations

from tacos_framework.plugins.discovery import PluginFailure, Plugins, Registered, contract_faults

__all__ = ["PluginFailure", "Plugins", "Registered", "contract_faults"]
