"""One test of a conformance suite, run on a component as on a plugin author's."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any


def apply(suite: type[Any], component: type[Any], test: str, tmp_path: Path) -> None:
    """Run the test of a name, with the fixtures it asks for; brackets behind the name hold a parameter."""
    bound = type("TestIt", (suite,), {"component": component, "files": ("found.txt",)})()
    offered = {
        "episode": lambda: bound.generate(),
        "renderer": bound.make,
        "executor": bound.make,
        "changes": lambda: {"gain_db": 20.0},
        "tmp_path": lambda: tmp_path,
        "told": lambda: test.removesuffix("]").partition("[")[2],
    }
    method = getattr(bound, test.partition("[")[0])
    method(**{name: offered[name]() for name in inspect.signature(method).parameters})


def apply_all(suite: type[Any], component: type[Any], tests: set[str], tmp_path: Path) -> None:
    """Run each of the tests, in a folder of its own."""
    for i, test in enumerate(sorted(tests)):
        (tmp_path / str(i)).mkdir()
        apply(suite, component, test, tmp_path / str(i))
