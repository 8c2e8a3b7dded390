"""What all tests share."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # `toy_plugin`, also in spawned workers

import toy_plugin

from tacos_framework.plugins import Plugins

collect_ignore = ["fuzz/harness.py"]  # run by hand: needs atheris

# Shells start what runs in the background with Ctrl-C ignored, and child processes would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def toys() -> Plugins:
    """The installed plugins and the toys."""
    plugins = Plugins.discover()
    plugins.register(toy_plugin)
    return plugins
