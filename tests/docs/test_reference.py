"""The pages written from the code are up to date, and the hand-written ones leave nothing out."""

from __future__ import annotations

import dataclasses
import inspect
import re

import pytest

from tacos_framework import values
from tacos_framework.components import KINDS
from tacos_framework.recipe import Recipe
from tacos_plugins.authoring.reference.pages import default_components, pages, pages_of_the_site
from tests.docs.pages import ROOT

REFERENCE = ROOT / "docs" / "reference"


PAGES = pages()


@pytest.mark.parametrize("name", PAGES)
def test_generated_page_is_up_to_date(name: str) -> None:
    assert (REFERENCE / name).read_text("utf-8") == PAGES[name](), "run `make docs` and commit what it writes"


def test_the_site_describes_every_component_and_every_key() -> None:
    text = "\n".join(write() for write in pages_of_the_site().values())
    assert {part.use for part in default_components() if f"\n## {part.use}\n" not in text} == set()
    assert {key for key in Recipe.model_fields if f"| `{key}` |" not in text} == set()


def test_no_meaning_begins_with_a_question() -> None:
    shown = "\n".join([*(write() for write in pages_of_the_site().values()), *(w() for w in PAGES.values())])
    assert re.findall(r"\| ((?:Whether|What|Who|How|Where|When|Nobody)\b[^|]*)", shown) == []


def test_the_recipe_page_names_every_key_at_the_top() -> None:
    text = (REFERENCE / "recipe.md").read_text("utf-8")
    assert {key for key in Recipe.model_fields if f"`{key}:`" not in text} == set()


def test_the_nomenclature_names_every_kind_and_every_value() -> None:
    text = (REFERENCE / "nomenclature.md").read_text("utf-8")
    names = {
        name for name, value in inspect.getmembers(values, inspect.isclass) if dataclasses.is_dataclass(value)
    }
    assert {word for word in {*KINDS, *names} if f"`{word}`" not in text} == set()
