"""The two commands: ``tacos-run RECIPE``, and ``tacos`` for everything around it.

Modules here import heavy packages only where they use them, so that help and lists come at once.
"""

from __future__ import annotations

from tacos_framework.cli.run import main as run_main
from tacos_framework.cli.run import parser as run_parser
from tacos_framework.cli.tacos import main as tacos_main
from tacos_framework.cli.tacos import parser as tacos_parser

__all__ = ["run_main", "run_parser", "tacos_main", "tacos_parser"]
