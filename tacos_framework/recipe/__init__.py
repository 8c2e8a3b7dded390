"""Recipes: one YAML file, or the same thing built in Python.

================  =========================================================================================
``sections``      the sections of a study's recipe
``recipe``        the whole of it, and what holds between sections
``parsing``       reading it, with all faults
``pipeline``      how a camera processes its files: effects, written out or by a name
``procedure``     a recipe that is no study
``written``       where the keys of a recipe stand in its text
``loading``       finding recipes by path or name
``run_folder``    what the folder of a run is known by
``overrides``     values put in from outside the file: ``--set`` and ``--with``
``fixing``        a design variable that ``--set`` fixes
``effect_names``  what design variables call the effects
``notes``         notes that quote settings
================  =========================================================================================
"""

from __future__ import annotations

from tacos_framework.recipe.loading import find_recipe, load_recipe, read_any_recipe
from tacos_framework.recipe.parsing import parse_recipe
from tacos_framework.recipe.procedure import ProcedureRecipe, is_procedure
from tacos_framework.recipe.recipe import FORMAT, Recipe
from tacos_framework.recipe.sections import (
    FIXED,
    Aim,
    Between,
    Bounds,
    Choose,
    Compare,
    EffectUse,
    FromCatalog,
    NamedScenario,
    NodeUse,
    Scenario,
    StudySettings,
    Test,
    Train,
    Use,
    Weighted,
)

__all__ = [
    "FIXED",
    "FORMAT",
    "Aim",
    "Between",
    "Bounds",
    "Choose",
    "Compare",
    "EffectUse",
    "FromCatalog",
    "NamedScenario",
    "NodeUse",
    "ProcedureRecipe",
    "Recipe",
    "Scenario",
    "StudySettings",
    "Test",
    "Train",
    "Use",
    "Weighted",
    "find_recipe",
    "is_procedure",
    "load_recipe",
    "parse_recipe",
    "read_any_recipe",
]
