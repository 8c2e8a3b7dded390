"""What all tests share."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # `toy_plugin`, also in spawned workers

import toy_plugin

from tacos_framework.plugins import Plugins


@pytest.fixture(scope="session")
def toys() -> Plugins:
    """The installed plugins and the toys."""
    plugins = Plugins.discover()
    plugins.register(toy_plugin)
    return plugins
