"""Tests of conformance suites, run on components as on those of a plugin author."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

MONOCULAR = {"focal_length_mm": 2.0, "sensor": {"width_px": 64, "height_px": 48, "pixel_um": 3.0}}

Fault = tuple[type[Any], type[Any], str]
"""A suite, a component with a fault, and the test that finds it; brackets behind it hold a parameter."""


def bound(suite: type[Any], component: type[Any]) -> Any:
    """The suite of a component, as a plugin author would write it."""
    own = {"component": component, "files": ("found.txt",), "variables": MONOCULAR}
    return type("TestIt", (suite,), own)()


def apply(suite: type[Any], component: type[Any], test: str, tmp_path: Path) -> None:
    """Run the test of a name, with the fixtures it asks for."""
    test_it = bound(suite, component)
    offered = {
        "episode": lambda: test_it.generate(),
        "renderer": test_it.make,
        "executor": test_it.make,
        "changes": lambda: {"gain_db": 20.0},
        "tmp_path": lambda: tmp_path,
        "told": lambda: test.removesuffix("]").partition("[")[2],
    }
    method = getattr(test_it, test.partition("[")[0])
    method(**{name: offered[name]() for name in inspect.signature(method).parameters})


def faults_are_found(faults: Sequence[Fault]) -> Callable[..., None]:
    """The test that each fault is found."""

    @pytest.mark.parametrize(("suite", "component", "test"), faults)
    def test(suite: type[Any], component: type[Any], test: str, tmp_path: Path) -> None:
        with pytest.raises(AssertionError):
            apply(suite, component, test, tmp_path)

    return test


def sound_ones_pass(
    sound: Sequence[tuple[type[Any], type[Any]]], faults: Sequence[Fault]
) -> Callable[..., None]:
    """The test that sound components pass what the faulty ones of their suite fail."""

    @pytest.mark.parametrize(("suite", "component"), sound)
    def test(suite: type[Any], component: type[Any], tmp_path: Path) -> None:
        for i, name in enumerate(sorted({test for kind, _, test in faults if kind is suite})):
            (tmp_path / str(i)).mkdir()
            apply(suite, component, name, tmp_path / str(i))

    return test
