"""The tutorials are followed step by step, in an environment of their own, and the docs' commands checked."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.pages import ROOT, blocks, commands, write_file
from tests.fresh_environment import REFUSED, FreshEnvironment

_CALL = "import sys; from tacos_framework.cli import {function}; sys.exit({function}())"


@pytest.fixture
def reader(tmp_path: Path) -> FreshEnvironment:
    """Somebody who follows a page in an environment of their own."""
    return FreshEnvironment.make(tmp_path)


def follow(page: Path, reader: FreshEnvironment) -> dict[str, str]:
    """Write the files of a page and run its commands, from top to bottom; what each command printed."""
    printed = {}
    for block in blocks(page):
        if block.title is not None:
            write_file(block, reader.folder)
        for line in commands(block):
            printed[line] = reader.expect(line)
    return printed


def test_first_plugin(reader: FreshEnvironment) -> None:
    printed = follow(ROOT / "docs/tutorials/first_plugin.md", reader)
    assert "task.objects-seen" in printed["tacos plugins"]
    assert (reader.folder / "run" / "report.html").is_file()


def test_add_a_catalog(reader: FreshEnvironment) -> None:
    printed = follow(ROOT / "docs/how-to/add_a_catalog.md", reader)
    assert "S-3   2048      1536       ?" in printed["tacos catalog my_sensors.csv"]


COMMANDS = [
    line
    for block in blocks()
    for line in commands(block)
    if line.startswith(("tacos-run headset", "tacos catalog image_sensors", "tacos plugins", "tacos doctor"))
    and "--with " not in line  # a file that the page makes; tests/docs/test_diagnosis_tutorial.py does so
    and "=runs/" not in line  # likewise
    and "=house.glb" not in line  # the reader's own; tests/worlds/imported walks through such files
    and ".glb" not in line  # a file of the reader's own
]


@pytest.mark.parametrize("line", COMMANDS)
def test_command_of_the_docs_is_understood(line: str, tmp_path: Path) -> None:
    """Commands that run a shipped recipe are checked, not run; those that only look are run."""
    script, *arguments = shlex.split(line, comments=True)
    if script == "tacos-run" and "--explain" not in arguments:
        arguments.append("--check")
    function = {"tacos-run": "run_main", "tacos": "tacos_main"}[script]
    done = subprocess.run(
        [sys.executable, "-c", _CALL.format(function=function), *arguments],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == (2 if line.endswith(REFUSED) else 0), done.stdout + done.stderr
