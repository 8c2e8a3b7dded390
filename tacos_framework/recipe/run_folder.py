"""What the folder of a run is known by."""

from __future__ import annotations

RUN_RECIPE = "recipe.yaml"
"""The recipe that a run keeps in its folder."""
