"""Design cameras for vision tasks in simulation, as a pipeline of plugins."""

from __future__ import annotations

__version__ = "0.1.0"
