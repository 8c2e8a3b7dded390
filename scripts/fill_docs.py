"""Fills the code blocks of the documentation that show examples: ``python scripts/fill_docs.py``.

A block with the title ``tacos-example-plugin/PATH`` shows that file, one with ``PATH:NAME`` a class or
function in it.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PROJECTS = ROOT / "tests" / "third_party"

_BLOCK = re.compile(
    r'^(?P<fence>```\w+ title="(?P<path>tacos-example-plugin/[^":]+)(?::(?P<name>\w+))?")\n'
    r".*?^```$",
    re.MULTILINE | re.DOTALL,
)


def filled(page: str) -> str:
    """A page with its blocks as the files are now."""
    return _BLOCK.sub(lambda found: f"{found['fence']}\n{shown(found['path'], found['name'])}```", page)


def shown(path: str, name: str | None) -> str:
    """A file of the examples, or one class or function of it.

    Raises
    ------
    LookupError
        When there is no such class or function at the top of the file.
    """
    text = (PROJECTS / path).read_text("utf-8")
    if name is None:
        return text
    for node in ast.parse(text).body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef) and node.name == name:
            lines = text.splitlines(keepends=True)
            return "".join(lines[node.lineno - 1 : node.end_lineno])
    raise LookupError(f"{path} has no class or function {name}")


def main() -> None:
    """Fill all pages."""
    for page in sorted((ROOT / "docs").rglob("*.md")):
        text = page.read_text("utf-8")
        if (new := filled(text)) != text:
            page.write_text(new, "utf-8")


if __name__ == "__main__":
    main()
