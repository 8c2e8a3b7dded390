"""The page on the architecture tells of the folders that are there, and of no others."""

from __future__ import annotations

import re

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
