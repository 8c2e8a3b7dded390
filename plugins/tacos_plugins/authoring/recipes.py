"""``tacos recipes``: the recipes that ship, a line each, and where they lie."""

from __future__ import annotations

import re
from itertools import takewhile
from pathlib import Path

from tacos_framework import read_yaml, recipe_folders, shipped_recipes
from tacos_framework.files import read_text

_SENTENCE = re.compile(r".+?[.?](?=\s+[A-Z]|$)")
"""The first sentence; the stop of "Sec. 4.3" ends none."""


def list_recipes() -> str:
    """The shipped recipes, a line each, and how they are used."""
    recipes = shipped_recipes()
    widest = max(map(len, recipes))
    lines = [f"{name:<{widest}}  {summary_of(file)}" for name, file in recipes.items()]
    folders = " and ".join(map(str, recipe_folders()))
    closing = f"They lie in {folders}. Run one by its name, tacos-run NAME, or a copy by its path."
    return "\n".join([*lines, "", closing])


def summary_of(recipe: Path) -> str:
    """Purpose of a recipe: the first sentence of the comment it begins with, else its name."""
    lines = takewhile(lambda line: re.match(r"# \S", line), read_text(recipe).splitlines())
    comment = " ".join(line.removeprefix("# ").strip() for line in lines)
    if (sentence := _SENTENCE.match(comment)) is not None:
        return sentence[0].removesuffix(".")
    return comment or str(read_yaml(recipe).data["name"])
