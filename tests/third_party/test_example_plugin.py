"""A plugin package of its own is installed, found, and passes its own tests: the third party's path."""

from __future__ import annotations

from pathlib import Path

from tests.fresh_environment import FreshEnvironment

PROJECT = Path(__file__).parent / "tacos-example-plugin"


def test_the_example_plugin_installs_and_passes_its_tests(tmp_path: Path) -> None:
    environment = FreshEnvironment.make(tmp_path)
    environment.expect(f"pip install --quiet {PROJECT}")
    listed = environment.expect("tacos plugins")
    assert listed.count("[tacos-example-plugin]") == 13
    assert "broken" not in listed
    environment.expect(f"tacos-run {PROJECT}/recipes/find_the_board.yaml --check")
    environment.expect(f"tacos-run {PROJECT}/recipes/keep_the_course.yaml --check")
    environment.expect(f"pytest -q -p no:cacheprovider {PROJECT}")
