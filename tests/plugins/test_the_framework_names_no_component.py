"""The framework works with whatever is installed: no string of it names a component of the default plugins.

Docstrings may, and examples in messages do: "such as", "as in", "e.g.".
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import tacos_framework
from tacos_framework.plugins import Plugins

ROOT = Path(tacos_framework.__file__).parent
OFFERED = [
    each.component
    for each in Plugins.discover()
    if each.distribution in ("tacos-framework", "tacos-validation")
]
USES = {component.use for component in OFFERED}
BARE = {component.name for component in OFFERED if component.kind == "effect" and "-" in component.name}
EXAMPLE = re.compile(r"\b(such as|as in|e\.g\.|like)\b")


def docstrings(tree: ast.Module) -> set[int]:
    """Nodes that are the documentation of a module, class, function or attribute."""
    alone = (node.value for node in ast.walk(tree) if isinstance(node, ast.Expr))
    return {id(node) for node in alone}


def strings(source: str) -> Iterator[tuple[int, str]]:
    """Line and text of every string of a program but its documentation."""
    tree = ast.parse(source)
    documentation = docstrings(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in documentation:
            yield node.lineno, node.value


def named(texts: Iterator[tuple[int, str]] | list[tuple[int, str]]) -> Iterator[tuple[int, str]]:
    """Line and name of every component that texts name, other than as an example."""
    for line, text in texts:
        if text in BARE:
            yield line, text
        for use in USES:
            found = re.search(rf"(?<![\w.-]){re.escape(use)}(?![\w-])", text)
            if found and not EXAMPLE.search(text[: found.start()]):
                yield line, use


def files() -> list[Path]:
    suffixes = {".py", ".j2", ".yaml", ".json", ".html", ".js", ".css"}
    return sorted(path for path in ROOT.rglob("*") if path.suffix in suffixes)


def test_names_are_found_where_they_stand() -> None:
    source = (
        '"""effect.vignetting"""\na = "use effect.vignetting"\nb = "such as effect.jpeg"\nc = "row-noise"\n'
    )
    assert list(named(strings(source))) == [(2, "effect.vignetting"), (4, "row-noise")]
    assert list(named([(1, "effect.vignetting-2, my.effect.jpeg")])) == []


def test_the_framework_names_no_component_of_the_default_plugins() -> None:
    assert "sensor.affine-noise" in USES
    assert "row-noise" in BARE
    found = []
    for path in files():
        source, place = path.read_text(), path.relative_to(ROOT).as_posix()
        texts = strings(source) if path.suffix == ".py" else enumerate(source.splitlines(), 1)
        found += [f"{place}:{n} {name}" for n, name in named(texts)]
    if found:
        pytest.fail("the framework names components of plugins:\n" + "\n".join(found))
