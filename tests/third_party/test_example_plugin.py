"""A plugin package of its own is installed, found, and passes its own tests: the third party's path."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.fresh_environment import FreshEnvironment

PROJECT = Path(__file__).parent / "tacos-example-plugin"
EXAMPLES = sorted(path.parent for path in Path(__file__).parents[2].glob("examples/*/pyproject.toml"))


def test_the_example_plugin_installs_and_passes_its_tests(tmp_path: Path) -> None:
    environment = FreshEnvironment.make(tmp_path)
    environment.expect(f"pip install --quiet {PROJECT}")
    listed = environment.expect("tacos plugins")
    assert listed.count("[tacos-example-plugin]") == 13
    assert "broken" not in listed
    environment.expect(f"tacos-run {PROJECT}/recipes/find_the_board.yaml --check")
    environment.expect(f"tacos-run {PROJECT}/recipes/keep_the_course.yaml --check")
    environment.expect(f"pytest -q -p no:cacheprovider {PROJECT}")


@pytest.mark.parametrize("project", EXAMPLES, ids=lambda path: path.name)
def test_the_tests_of_examples_begin(project: Path) -> None:
    """Their modules import and read their files; the tests themselves run where the package is installed."""
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "--collect-only", "-p", "no:cacheprovider", "."],
        cwd=project,
        env={**os.environ, "PYTHONPATH": str(project / "src")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
