"""Files that mark the folder of a run."""

from __future__ import annotations

RUN_RECIPE = "recipe.yaml"
"""The recipe that a run keeps in its folder."""
