"""The tutorials are followed step by step, in an environment of their own, and the docs' commands checked."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
import sysconfig
import venv
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.docs.pages import ROOT, blocks, commands, write_file

REFUSED = "# refused"
"""Ends a command of the docs that is meant to fail with status 2."""

_CALL = "import sys; from tacos_framework.cli import {function}; sys.exit({function}())"
_SCRIPT = """#!{python}
import sys
from {module} import {function}
sys.exit({function}())
"""


@dataclass(frozen=True)
class Reader:
    """Somebody who follows a tutorial in a folder, with the commands of a fresh environment on the path."""

    folder: Path
    bin: Path

    def run(self, line: str) -> subprocess.CompletedProcess[str]:
        """Run one command; pip takes nothing from the network."""
        environment = {
            **os.environ,
            "PATH": f"{self.bin}{os.pathsep}{os.environ['PATH']}",
            "PIP_NO_INDEX": "1",
            "PIP_NO_DEPS": "1",
            "PIP_NO_BUILD_ISOLATION": "0",  # pip reads the negation of a negation: no isolation
            "PIP_DISABLE_PIP_VERSION_CHECK": "1",
        }
        return subprocess.run(
            shlex.split(line, comments=True),
            cwd=self.folder,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )

    def expect(self, line: str) -> str:
        """Run one command and see it end as the tutorial says; returns what it printed."""
        done = self.run(line)
        status = 2 if line.endswith(REFUSED) else 0
        assert done.returncode == status, f"{line}\n{done.stdout}\n{done.stderr}"
        assert "Traceback" not in done.stderr
        return done.stdout + done.stderr


@pytest.fixture
def reader(tmp_path: Path) -> Reader:
    """A reader whose environment sees what is installed here, and where a plugin can be added."""
    home = tmp_path / "venv"
    venv.create(home, symlinks=True)
    scripts = home / "bin"
    (site,) = (home / "lib").glob("python*/site-packages")
    here = sysconfig.get_paths()["purelib"]
    (site / "_outer.pth").write_text(f"import site; site.addsitedir({here!r})\n")
    commands = {
        "pip": ("pip._internal.cli.main", "main"),
        "pytest": ("pytest", "main"),
        "tacos": ("tacos_framework.cli", "tacos_main"),
        "tacos-run": ("tacos_framework.cli", "run_main"),
    }
    for name, (module, function) in commands.items():
        script = scripts / name
        script.write_text(_SCRIPT.format(python=scripts / "python", module=module, function=function))
        script.chmod(0o755)
    folder = tmp_path / "work"
    folder.mkdir()
    return Reader(folder, scripts)


def follow(page: Path, reader: Reader) -> dict[str, str]:
    """Write the files of a page and run its commands, from top to bottom; what each command printed."""
    printed = {}
    for block in blocks(page):
        if block.title is not None:
            write_file(block, reader.folder)
        for line in commands(block):
            printed[line] = reader.expect(line)
    return printed


def test_first_plugin(reader: Reader) -> None:
    printed = follow(ROOT / "docs/tutorials/first_plugin.md", reader)
    assert "task.objects-seen" in printed["tacos plugins"]
    assert (reader.folder / "run" / "report.html").is_file()


def test_add_a_catalog(reader: Reader) -> None:
    printed = follow(ROOT / "docs/how-to/add_a_catalog.md", reader)
    assert "S-3   2048      1536       ?" in printed["tacos catalog my_sensors.csv"]


COMMANDS = [
    line
    for block in blocks()
    for line in commands(block)
    if line.startswith(("tacos-run headset", "tacos catalog image_sensors", "tacos plugins", "tacos doctor"))
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
