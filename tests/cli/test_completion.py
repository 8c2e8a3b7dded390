"""Completion scripts offer what can be typed, in each shell that is at hand."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from tacos_plugins.authoring.commands import SHELLS
from tacos_plugins.authoring.completion import completion_script

WORDS = [
    (["tacos-run", "headset_q"], "headset_quick"),
    (["tacos-run", "mine"], "mine.yaml"),
    (["tacos-run", "--res"], "--resume"),
    (["tacos-run", "headset_quick", "--executor", "executor.p"], "executor.process"),
    (["tacos", "new-"], "new-plugin"),
    (["tacos", "catalog", "image_sensors_"], "image_sensors_more"),
    (["tacos", "captures", "sim"], "simulate"),
    (["tacos", "captures", "simulate", "ben"], "bench"),
    (["tacos", "new-plugin", "fog", "--kind", "eff"], "effect"),
]


def needs(shell: str) -> str:
    """The shell's program; skips the test without it."""
    program = shutil.which(shell)
    if program is None:
        pytest.skip(f"{shell} is not installed")
    return program


def run(shell: str, script: str, folder: Path) -> str:
    program = needs(shell)
    done = subprocess.run(
        [program, "-c", script], cwd=folder, capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return done.stdout


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a recipe and with something else."""
    (tmp_path / "mine.yaml").touch()
    (tmp_path / "mine.txt").touch()
    return tmp_path


@pytest.mark.parametrize(("words", "offered"), WORDS, ids=lambda value: str(value))
def test_bash_completes(words: list[str], offered: str, folder: Path) -> None:
    (folder / "complete.bash").write_text(completion_script("bash"))
    function = f"_shtab_{words[0].replace('-', '_')}"
    script = (
        f"source complete.bash; COMP_WORDS=({' '.join(words)}); COMP_CWORD={len(words) - 1}; "
        f"{function}; printf '%s\\n' \"${{COMPREPLY[@]}}\""
    )
    assert run("bash", script, folder).split() == [offered]


@pytest.mark.parametrize(("words", "offered"), WORDS, ids=lambda value: str(value))
def test_fish_completes(words: list[str], offered: str, folder: Path) -> None:
    (folder / "complete.fish").write_text(completion_script("fish"))
    script = f"source complete.fish; complete -C '{' '.join(words)}'"
    found = {line.partition("\t")[0] for line in run("fish", script, folder).splitlines()}
    assert offered in found


@pytest.mark.parametrize("shell", SHELLS)
@pytest.mark.parametrize("command", ["tacos", "tacos-run"])
def test_each_shell_can_read_its_script(shell: str, command: str, tmp_path: Path) -> None:
    script = tmp_path / "script"
    script.write_text(completion_script(shell, command))
    done = subprocess.run([needs(shell), "-n", str(script)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_zsh_knows_recipes_and_executors() -> None:
    script = completion_script("zsh", "tacos-run")
    assert script.startswith("#compdef tacos-run")
    assert "headset_quick" in script
    assert "executor.process" in script
