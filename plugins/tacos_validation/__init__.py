"""Checks of the simulator, the diagnosis and the search, as a distribution of its own."""

__version__ = "0.1.0"
