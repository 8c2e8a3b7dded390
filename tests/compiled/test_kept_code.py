"""Machine code that is kept on disk is that of what stands in the files now."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

LOOP = """
from tacos_plugins.compiled.loops import compiled, inlined, unaliased
from layout import WIDTH, scaled

@{decorator}
def area(height):
    return scaled(height * WIDTH)

print(area(10), sum(area.stats.cache_hits.values()))
"""
LAYOUT = """
from tacos_plugins.compiled.loops import compiled, inlined, unaliased

WIDTH = {width}

@{part}
def scaled(number):
    return {scale} * number
"""


def run(folder):
    """What the loop gives, and whether its code was taken from disk, in a process of its own."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder / "code")}
    command = [sys.executable, "-B", "loop.py"]  # no bytecode: times of files within a second are equal
    said = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=120)
    assert said.returncode == 0, said.stderr
    value, hits = said.stdout.split()
    return int(value), bool(int(hits))


@pytest.mark.parametrize(("decorator", "part"), [("compiled", "inlined"), ("unaliased", "compiled")])
def test_a_change_in_another_file_is_compiled_in(tmp_path, decorator, part):
    def write(width, scale):
        (tmp_path / "layout.py").write_text(LAYOUT.format(part=part, width=width, scale=scale))

    (tmp_path / "loop.py").write_text(LOOP.format(decorator=decorator))
    write(width=2, scale=1)
    assert run(tmp_path) == (20, False)
    assert run(tmp_path) == (20, True)
    write(width=3, scale=1)
    assert run(tmp_path) == (30, False)
    write(width=3, scale=4)
    assert run(tmp_path) == (120, False)
    assert run(tmp_path) == (120, True)
