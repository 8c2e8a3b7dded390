"""Links lead somewhere, code blocks can be read, names exist."""

from __future__ import annotations

import ast
import json
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

from tacos_framework import ProcedureRecipe, load_recipe
from tacos_framework.components import KINDS
from tacos_framework.plan import make_plan
from tacos_framework.plan.procedure import plan_procedure
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import parse_recipe
from tacos_framework.settings.yaml_reader import read_yaml
from tests.docs.pages import PAGES, ROOT, Block, anchors, blocks, commands, links, write_file

LANGUAGES = {"python", "yaml", "toml", "json", "sh", "console", "text", "csv"}
COMPONENT = re.compile(rf"`((?:{'|'.join(KINDS)})\.[a-z][a-z0-9-]*)`")
OFFERED = re.compile(r'Component\(\s*"([a-z]+)",\s*"([a-z0-9-]+)"')


def page_name(page: Path) -> str:
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_links_lead_somewhere(page: Path) -> None:
    for target in links(page):
        path, _, anchor = target.partition("#")
        other = (page.parent / path).resolve() if path else page
        assert other.exists(), f"{page_name(page)} links to {target}, which is not there"
        if anchor:
            assert anchor in anchors(other), f"{page_name(page)} links to {target}: no such heading"


def test_every_page_can_be_reached_from_the_index() -> None:
    start = ROOT / "docs" / "index.md"
    reached, to_read = {start}, [start]
    while to_read:
        page = to_read.pop()
        targets = {(page.parent / link.partition("#")[0]).resolve() for link in links(page)}
        new = {path for path in targets if path.suffix == ".md" and path not in reached}
        reached |= new
        to_read += new
    assert {page_name(page) for page in set(PAGES) - reached if page.is_relative_to(start.parent)} == set()


@pytest.mark.parametrize("block", blocks(), ids=str)
def test_code_block_can_be_read(block: Block) -> None:
    assert block.language in LANGUAGES, f"{block}: name the language, one of {', '.join(sorted(LANGUAGES))}"
    match block.language:
        case "python":
            ast.parse(block.text, filename=str(block))
        case "yaml":
            read_yaml(block.text, name=str(block))
        case "toml":
            tomllib.loads(block.text)
        case "json":
            json.loads(block.text)
        case "sh" | "console":
            for line in commands(block):
                shlex.split(line, comments=True)


RECIPES = [block for block in blocks(language="yaml") if block.text.startswith("tacos:") and not block.title]


PROCEDURES = [block for block in RECIPES if "\nuse: procedure." in block.text]
STUDIES = [block for block in RECIPES if block not in PROCEDURES]


@pytest.mark.parametrize("block", STUDIES, ids=str)
def test_whole_recipe_passes_the_check(block: Block) -> None:
    recipe, faults = parse_recipe(block.text, name=str(block))
    assert make_plan(recipe, Plugins.discover(), faults).graph.nodes


@pytest.mark.parametrize("block", PROCEDURES, ids=str)
def test_whole_recipe_of_a_procedure_passes_the_check(block: Block) -> None:
    recipe = load_recipe(yaml.safe_load(block.text))
    assert isinstance(recipe, ProcedureRecipe)
    plan_procedure(recipe, Plugins.discover())


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_components_named_exist(page: Path) -> None:
    text = page.read_text("utf-8")
    own = {f"{kind}.{name}" for kind, name in OFFERED.findall(text)}
    installed = {registered.component.use for registered in Plugins.discover()}
    assert set(COMPONENT.findall(text)) <= installed | own


def pages_with_code() -> list[Path]:
    """Pages whose Python runs from top to bottom; the tutorials' is tested by following them."""
    pages = {block.page for block in blocks(language="python") if block.title is None}
    return sorted(page for page in pages if page.parent.name in ("how-to", "explanation"))


@pytest.mark.parametrize("page", pages_with_code(), ids=page_name)
def test_python_runs_and_prints_what_the_page_says(page: Path, tmp_path: Path) -> None:
    script, printed = [], []
    previous = None
    for block in blocks(page):
        if block.title is not None:
            write_file(block, tmp_path)
        elif block.language == "python":
            script.append(block.text)
        elif block.language == "text" and previous is not None and previous.language == "python":
            printed.append(block.text)
        previous = block
    done = subprocess.run(
        [sys.executable, "-c", "\n".join(script)], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    for text in printed:
        assert text in done.stdout
