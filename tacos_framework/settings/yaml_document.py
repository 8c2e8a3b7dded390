"""A YAML text with the position of each entry."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from tacos_framework.errors import Fault


class Position(NamedTuple):
    """A position in a text; line and column count from 1."""

    line: int
    column: int

    def of(self, name: str) -> str:
        """``name:line:column``, as messages have it."""
        return f"{name}:{self.line}:{self.column}"


@dataclass(frozen=True)
class Document:
    """The value of a YAML text, with positions.

    >>> from tacos_framework.settings.yaml_reader import read_yaml
    >>> document = read_yaml("rig:\\n  pitch_deg: 1e1\\n", name="recipe.yaml")
    >>> document.data
    {'rig': {'pitch_deg': 10.0}}
    >>> document.where(("rig", "pitch_deg"))
    'recipe.yaml:2:3'
    """

    data: Any
    """Nested `dict` (text keys), `list`, `str`, `int`, `float`, `bool` and None."""
    positions: Mapping[tuple[str | int, ...], Position]
    """For the path of each entry its position: of the key in a mapping, of the item in a list. A path is the
    keys and list indices on the way from the root, which is ``()``.
    """
    name: str
    """Name of the text in messages, usually its file."""
    elsewhere: Mapping[tuple[str | int, ...], str] = field(default_factory=dict)
    """Name, in messages, of entries that were put there from elsewhere, such as the command line."""
    faults: tuple[Fault, ...] = ()
    """Refused parts of the text, where the rest can still be looked at."""
    unread: frozenset[tuple[str | int, ...]] = frozenset()
    """Paths of the values among it that were read as None, for want of a better one."""

    def where(self, path: Sequence[str | int] = ()) -> str:
        """``name:line:column`` of the entry, or of its nearest ancestor that exists.

        An entry from elsewhere, and all that stands below it, has the name of where it came from.
        """
        known = tuple(path)
        for length in range(len(known), 0, -1):
            if known[:length] in self.elsewhere:
                return self.elsewhere[known[:length]]
        while known and known not in self.positions:
            if made := next((name for key, name in self.elsewhere.items() if key[: len(known)] == known), ""):
                return made  # it stands there only because something below was put in
            known = known[:-1]
        return self.positions.get(known, Position(1, 1)).of(self.name)

    def folder_of(self, path: Sequence[str | int]) -> Path | None:
        """The folder that a relative path at an entry starts from; None for the working folder.

        What a file says starts beside the file, what came from the command line where that was typed.
        """
        known = tuple(path)
        if any(known[: len(given)] == given for given in self.elsewhere) or not Path(self.name).is_file():
            return None
        return Path(self.name).parent

    def without_echoes(self, faults: Iterable[Fault]) -> list[Fault]:
        """The faults, but for those that only say once more that a value could not be read."""
        unread = {self.where(path) for path in self.unread}
        return [fault for fault in faults if fault in self.faults or fault.where not in unread]
