"""The embedding example runs as a host would run it; all public names are there, with their types."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

import tacos_framework

EXAMPLE = Path(__file__).parent / "design_a_camera.py"


def test_the_example_runs_as_a_program(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", str(EXAMPLE), str(tmp_path / "out")],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        env=os.environ,
    )
    assert done.returncode == 0, done.stderr
    said = done.stdout.splitlines()
    assert said[0] == "Designing: 4 candidates"
    assert sum(line.startswith("best so far: ") for line in said) >= 2
    assert " mm, tilted by " in said[-1]
    assert (tmp_path / "out" / "result.json").is_file()


@pytest.mark.parametrize("name", sorted(tacos_framework.__all__))
def test_every_public_name_is_there(name: str) -> None:
    assert getattr(tacos_framework, name) is not None


def test_every_contract_and_every_value_is_public() -> None:
    from tacos_framework import contracts, values

    assert set(values.__all__) <= set(tacos_framework.__all__)
    kinds = {protocol.__name__ for protocol in contracts.PROTOCOLS.values()}
    assert kinds <= set(tacos_framework.__all__)


def test_a_name_that_is_not_there_is_an_error() -> None:
    with pytest.raises(AttributeError, match="tacos_framework attribute Sensr"):
        tacos_framework.Sensr  # noqa: B018


def _negated(node: ast.If) -> bool:
    return isinstance(node.test, ast.UnaryOp)
