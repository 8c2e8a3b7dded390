"""The packages of `examples/` install beside the framework, are found, and pass their own tests."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fresh_environment import FreshEnvironment

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(each.parent.name for each in EXAMPLES.glob("*/pyproject.toml")))
def test_it_installs_and_passes_its_tests(name: str, tmp_path: Path) -> None:
    environment = FreshEnvironment.make(tmp_path)
    environment.expect(f"pip install --quiet {EXAMPLES / name}")
    listed = environment.expect("tacos plugins")
    assert listed.count(f"[{name}]") == 2
    assert "broken" not in listed
    environment.expect(f"pytest -q -p no:cacheprovider {EXAMPLES / name}")
