"""The how-to pages show the example plugin as it is, and there is one for each kind."""

from __future__ import annotations

from pathlib import Path

import pytest

from scripts.fill_docs import PROJECTS, filled, shown
from tacos_framework.components import KINDS
from tests.docs.pages import PAGES, ROOT, blocks

HOW_TO = ROOT / "docs" / "how-to"
EXAMPLE = "tacos-example-plugin/"
WITH_EXAMPLE = sorted({block.page for block in blocks() if (block.title or "").startswith(EXAMPLE)})


@pytest.mark.parametrize("page", WITH_EXAMPLE, ids=lambda page: page.stem)
def test_shown_files_are_up_to_date(page: Path) -> None:
    text = page.read_text("utf-8")
    assert filled(text) == text, "run `make docs` and commit what it writes"


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_has_a_page_that_shows_a_component_and_its_test(kind: str) -> None:
    article = "an" if kind[0] in "aeiou" else "a"
    titles = [str(block.title) for block in blocks(HOW_TO / f"write_{article}_{kind}.md")]
    assert any(title.startswith(f"{EXAMPLE}src/") for title in titles)
    assert any(title.startswith(f"{EXAMPLE}tests/") for title in titles)


def test_every_component_of_the_example_is_shown() -> None:
    titles = {str(block.title).partition(":")[0] for page in PAGES for block in blocks(page)}
    package = PROJECTS / "tacos-example-plugin" / "src"
    files = {f"{EXAMPLE}src/{path.relative_to(package)}" for path in package.rglob("*.py")}
    assert {file for file in files - titles if not file.endswith("__init__.py")} == set()


def test_a_changed_block_is_filled_anew() -> None:
    path = f"{EXAMPLE}src/tacos_example/__init__.py"
    page = f'# Page\n\n```python title="{path}"\nold\n```\n\n```python\nkept\n```\n'
    assert filled(page) == page.replace("old\n", shown(path, None))


def test_a_class_that_is_gone_is_named() -> None:
    with pytest.raises(LookupError, match="has no class or function Gone"):
        shown(f"{EXAMPLE}src/tacos_example/haze.py", "Gone")
