"""The page of the threat model: each promise names a test that is there, limits are those of the code."""

from __future__ import annotations

import ast
import re
from dataclasses import asdict
from pathlib import Path

import pytest

from tacos_framework.files import Limits
from tests.fuzz.protections import PROTECTIONS

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "explanation" / "threat_model.md").read_text("utf-8")
TESTS = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", PAGE)


def rows(heading: str) -> list[str]:
    """The rows of the table below a heading."""
    section = PAGE.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    return [line for line in section.splitlines() if line.startswith("|")][2:]


def test_every_test_that_is_named_is_there():
    assert TESTS
    missing = [
        f"{file}::{name}"
        for file, name in TESTS
        if not any(
            isinstance(node, ast.FunctionDef) and node.name == name
            for node in ast.walk(ast.parse((ROOT / file).read_text("utf-8")))
        )
    ]
    assert not missing


@pytest.mark.parametrize("heading", ["Not trusted", "Faulty plugins"])
def test_every_promise_names_a_test(heading):
    found = rows(heading)
    assert len(found) > 5
    assert not [row for row in found if not re.search(r"`tests/[\w/]+\.py::\w+`", row)]


def test_the_page_lists_every_limit():
    limits = re.findall(r"^\| `(\w+_\w+)` \| (\d+) \|", PAGE, re.MULTILINE)
    assert {name: float(value) for name, value in limits} == asdict(Limits())


@pytest.mark.parametrize("protection", PROTECTIONS, ids=lambda protection: protection.promise)
def test_protections_that_are_taken_away_by_hand_are_there(protection):
    assert (ROOT / protection.file).read_text("utf-8").count(protection.line) == 1
    assert protection.test.split("::", 1) in [list(each) for each in TESTS]
