"""The page on the architecture tells of the folders that are there, and of no others."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from tests.docs.pages import ROOT

PAGE = (ROOT / "docs" / "explanation" / "architecture.md").read_text("utf-8")


def rows_below(heading: str) -> set[str]:
    """The first cells of the table below a heading."""
    section = PAGE.partition(f"## {heading}\n")[2].partition("\n## ")[0]
    return set(re.findall(r"^\| `(\w+)` \|", section, flags=re.MULTILINE))


def packages_in(folder: str) -> set[str]:
    return {path.parent.name for path in (ROOT / folder).glob("*/__init__.py")}


def test_it_names_every_package() -> None:
    assert rows_below("Packages") == {"tacos_framework", *packages_in("plugins")}


def test_it_names_every_folder_of_the_core() -> None:
    assert rows_below("The core") == packages_in("tacos_framework")


@pytest.mark.parametrize("stage", ["scene", "optics", "exposure", "pixel", "readout", "isp", "codec"])
def test_it_tells_where_each_stage_acts(stage: str) -> None:
    assert f"*{stage}*" in PAGE.partition("## One image formation")[2]


def table_of_modules(package: Path) -> set[str]:
    """The modules that the docstring of a package lists, one a line; none where it has no table."""
    text = ast.get_docstring(ast.parse((package / "__init__.py").read_text("utf-8"))) or ""
    lines = text.partition("\n====")[2].splitlines()
    return {name for line in lines for name in re.findall(r"``(\w+)``", line)}


LISTING = [
    path.parent.name
    for path in sorted((ROOT / "tacos_framework").glob("*/__init__.py"))
    if path.parent.name != "contracts"  # whose table has kinds of components
    and table_of_modules(path.parent)
]


@pytest.mark.parametrize("package", LISTING)
def test_a_table_of_modules_has_each_that_is_there(package: str) -> None:
    folder = ROOT / "tacos_framework" / package
    assert table_of_modules(folder) == {path.stem for path in folder.glob("*.py")} - {"__init__"}
