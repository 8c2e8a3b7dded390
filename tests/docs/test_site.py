"""The site leaves no page and no public name out; `make docs` builds it."""

from __future__ import annotations

import re
from importlib.util import find_spec

import pytest

import tacos_framework
from tests.docs.pages import ROOT

if find_spec("mkdocs") is None:
    pytest.skip("needs the extra docs", allow_module_level=True)

from mkdocs.config.defaults import MkDocsConfig

from scripts.site_examples import with_heading
from scripts.site_pages import api_pages, names_for_users, navigation, on_config

DOCS = ROOT / "docs"


def test_navigation_names_each_page_once() -> None:
    sections = navigation((DOCS / "index.md").read_text("utf-8"))
    entries = [entry for section in sections for entries in section.values() for entry in entries]
    named = [page for entry in entries for page in entry.values()]
    written = {str(page.relative_to(DOCS)) for page in DOCS.rglob("*.md")} - {"index.md"}
    assert sorted(named) == sorted(written)


def test_settings_and_keys_are_looked_up_in_the_site() -> None:
    config = MkDocsConfig()
    config.docs_dir = str(DOCS)
    sections = {name: pages for section in on_config(config).nav or [] for name, pages in section.items()}
    assert {"Keys of a recipe": "reference/keys_of_a_recipe.md"} in sections["Look up"]
    assert list(sections)[-1] == "API"


def test_each_public_name_of_the_core_is_described_once() -> None:
    described = re.findall(r"^::: tacos_framework\.(\S+)", "\n".join(api_pages().values()), re.MULTILINE)
    assert sorted(described) == sorted({*tacos_framework.__all__, "testing"})


def test_page_of_users_names_what_tacos_exports() -> None:
    import tacos

    assert {name.rpartition(".")[2] for name in names_for_users()} == set(tacos.__all__) - {"__version__"}


def test_examples_of_docstrings_have_their_heading_in_the_site() -> None:
    shown = with_heading("Twice a number.\n\n>>> twice(2)\n4\n>>> twice(3)\n6")
    assert shown == "Twice a number.\n\nExamples\n--------\n>>> twice(2)\n4\n>>> twice(3)\n6"
