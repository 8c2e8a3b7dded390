"""Shows the examples of docstrings as such: an extension of griffe (``mkdocs.yml``), for `make docs`."""

from __future__ import annotations

import re
from typing import Any

import griffe

_FIRST_EXAMPLE = re.compile(r"^(?=>>> )", re.MULTILINE)


class ExamplesFromPrompts(griffe.Extension):
    """Begins the section of examples at the first prompt, which docstrings of this project do not head."""

    def on_instance(self, *, obj: griffe.Object, **_: Any) -> None:
        if obj.docstring:
            obj.docstring.value = with_heading(obj.docstring.value)


def with_heading(docstring: str) -> str:
    """A docstring with a heading above its examples, as numpydoc has it."""
    return _FIRST_EXAMPLE.sub("Examples\n--------\n", docstring, count=1)
