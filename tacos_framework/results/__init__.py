"""The results folder of a run."""

from __future__ import annotations

from tacos_framework.results.results import Results

__all__ = ["Results"]
