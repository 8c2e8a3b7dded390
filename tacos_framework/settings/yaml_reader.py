"""YAML that people write, read strictly, with a position for everything in it.

The dialect is the one most people believe YAML to be: scalars of the YAML 1.2 core schema (``1e-3`` is a
number, ``no`` and ``on`` are words, ``010`` is ten), plain mappings with distinct text keys, lists, one
document. What can surprise or harm is refused: aliases and anchors (unless asked for, and then bounded, as
they blow up in size), tags, merge keys, NaN and infinities, files over the limit ``text_mb``, nesting over 50
levels.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import yaml

from tacos_framework.errors import Fault, UserError
from tacos_framework.files import limits, read_text
from tacos_framework.files.regular import too_large
from tacos_framework.settings.yaml_document import Document, Position
from tacos_framework.settings.yaml_scalars import LONGEST_NUMBER, plain_scalar

MAX_DEPTH = 50
"""Deepest nesting of mappings and lists that is read."""

MAX_REPEATED = 10_000
"""Most entries that aliases may repeat in all, where they are read."""

_NOT_STORABLE = re.compile("[\x00\ud800-\udfff]")
_NOWHERE = -1
"""A step of a path that no entry has: for keys while they are read, and for what stands below bad ones."""

_REMEDIES = {
    r"'\t'": "Indent with spaces, not with tabs.",
    "mapping values are not allowed": "Quote text that holds a colon, and check the indentation.",
    "could not find expected ':'": "Write 'key: value', with a space after the colon.",
    "that cannot start any token": "Quote text that starts with a special character.",
}


def read_yaml(source: Path | str, name: str | None = None, *, aliases: bool = False) -> Document:
    """Read a YAML file (`pathlib.Path`) or text (`str`).

    - `source`: the file or the text itself.
    - `name`: what to call it in messages; the path, or ``"text"``, when left out.
    - `aliases`: whether aliases stand for what they name, as programs write what they hold twice.

    Raises `UserError` with every fault that can be found in one pass.
    """
    document = read_yaml_draft(source, name, aliases=aliases)
    if document.faults:
        raise UserError(document.faults)
    return document


def read_yaml_draft(source: Path | str, name: str | None = None, *, aliases: bool = False) -> Document:
    """As `read_yaml`, where what was refused is looked at together with other faults.

    Raises `UserError` when there is no document to look at: the file cannot be read, or is not YAML.
    """
    if isinstance(source, Path):
        name = str(source) if name is None else name
        text = read_text(source, where=name)
    else:
        name = "text" if name is None else name
        text = source
        if len(text) > limits().bytes_of("text_mb"):
            raise UserError(too_large(name, "the text", len(text), "text_mb"))
    return _Reader(text, name, aliases).document()


def _position(mark: Any) -> Position:
    return Position(mark.line + 1, mark.column + 1) if mark else Position(1, 1)


class _Reader:
    """Builds the document from parser events, which come without recursion or construction of objects."""

    def __init__(self, text: str, name: str, aliases: bool):
        self.text = text
        self.name = name
        self.aliases = aliases
        self.anchored: dict[str, tuple[Any, int]] = {}  # what is named, and how many entries it holds
        self.entries = self.repeated = 0
        self.faults: list[Fault] = []
        self.positions: dict[tuple[str | int, ...], Position] = {}
        self.unread: set[tuple[str | int, ...]] = set()

    def document(self) -> Document:
        """The whole text with what was refused in it, or all that is wrong where it is no YAML."""
        try:
            self.loader = yaml.SafeLoader(self.text)
            data = self._stream()
            unread = frozenset(path for path in self.unread if _NOWHERE not in path)
            return Document(data, self.positions, self.name, faults=tuple(self.faults), unread=unread)
        except yaml.reader.ReaderError as error:
            before = self.text[: error.position]
            position = Position(before.count("\n") + 1, error.position - before.rfind("\n"))
            self._fault(position, f"character {chr(error.character)!r} is not allowed in YAML")
        except yaml.MarkedYAMLError as error:
            context = f" {error.context}" if error.context else ""
            what = f"this is not valid YAML: {error.problem}{context}"
            remedy = next((text for sign, text in _REMEDIES.items() if sign in what), "")
            self._fault(_position(error.problem_mark or error.context_mark), what, remedy=remedy)
        except (ValueError, OverflowError) as error:  # PyYAML lets chr() and int() of absurd escapes pass
            self._fault(_position(self.loader.get_mark()), f"this is not valid YAML: {error}")
        raise UserError(self.faults)

    def _fault(self, position: Position, what: str, expected: str = "", remedy: str = "") -> None:
        self.faults.append(Fault(position.of(self.name), what, expected, remedy))

    def _stream(self) -> Any:
        self.loader.get_event()  # stream start
        if self.loader.check_event(yaml.StreamEndEvent):
            return None
        self.loader.get_event()  # document start
        data = self._value((), depth=0)
        self.loader.get_event()  # document end
        if not self.loader.check_event(yaml.StreamEndEvent):
            second = _position(self.loader.get_event().start_mark)
            if not self._ends_with_nothing():
                self._fault(
                    second, "a second document starts here", "one document in a file", "Remove the '---'."
                )
        return data

    def _ends_with_nothing(self) -> bool:
        """True if a document that has begun is empty and the last, as behind messages that ROS prints."""
        content, _ = self.loader.get_event(), self.loader.get_event()
        is_empty = isinstance(content, yaml.ScalarEvent) and not content.value and content.implicit[0]
        return is_empty and self.loader.check_event(yaml.StreamEndEvent)

    def _value(self, path: tuple[str | int, ...], depth: int) -> Any:
        event = self.loader.get_event()
        position = _position(event.start_mark)
        self.positions.setdefault(path, position)
        if depth > MAX_DEPTH:
            self._fault(position, f"nesting is deeper than {MAX_DEPTH} levels", f"at most {MAX_DEPTH} levels")
            raise UserError(self.faults)
        self.entries += 1
        if isinstance(event, yaml.AliasEvent):
            return self._alias(event.anchor, path, position, depth)
        if event.anchor is not None and not self.aliases:
            self._fault(position, f"anchor &{event.anchor} is not supported", remedy="Remove it.")
        if event.tag is not None:
            self._fault(position, f"tag {event.tag} is not supported", remedy="Remove it.")
        before = self.entries
        value: Any
        if isinstance(event, yaml.MappingStartEvent):
            value = self._mapping(path, depth)
        elif isinstance(event, yaml.SequenceStartEvent):
            value = self._list(path, depth)
        else:
            value = self._scalar(event, path, position)
        if event.anchor is not None:
            self.anchored[event.anchor] = value, self.entries - before + 1
        return value

    def _alias(self, name: str | None, path: tuple[str | int, ...], position: Position, depth: int) -> Any:
        """The value of an alias; None after reporting one that cannot be read."""
        if not self.aliases:
            self._fault(position, f"alias *{name} is not supported", remedy="Write the value out.")
        elif name is None or name not in self.anchored:
            self._fault(position, f"alias *{name} names nothing that ends before it", f"&{name} above")
        else:
            value, entries = self.anchored[name]
            self.entries += entries
            self.repeated += entries
            if self.repeated > MAX_REPEATED or depth + _height(value) > MAX_DEPTH:
                what = (
                    f"aliases repeat more than {MAX_REPEATED} entries, or nest deeper than {MAX_DEPTH} levels"
                )
                self._fault(position, what, remedy="Write the values out.")
                raise UserError(self.faults)
            return value
        self.unread.add(path)
        return None

    def _list(self, path: tuple[str | int, ...], depth: int) -> list[Any]:
        items: list[Any] = []
        while not self.loader.check_event(yaml.SequenceEndEvent):
            items.append(self._value((*path, len(items)), depth + 1))
        self.loader.get_event()
        return items

    def _mapping(self, path: tuple[str | int, ...], depth: int) -> dict[str, Any]:
        mapping: dict[str, Any] = {}
        while not self.loader.check_event(yaml.MappingEndEvent):
            position = _position(self.loader.peek_event().start_mark)
            key = self._key(path, depth)
            if isinstance(key, str) and key not in mapping:
                self.positions[(*path, key)] = position
                mapping[key] = self._value((*path, key), depth + 1)
                continue
            if isinstance(key, str):
                first = self.positions[(*path, key)]
                self._fault(
                    position,
                    f"key {key!r} stands here again, first in line {first.line}",
                    remedy="Remove one.",
                )
            self._value((*path, _NOWHERE), depth + 1)  # read on, for the faults that may be there
        self.loader.get_event()
        return mapping

    def _key(self, path: tuple[str | int, ...], depth: int) -> str | None:
        """The next key, which must be text; None after reporting any other."""
        event = self.loader.peek_event()
        position = _position(event.start_mark)
        plain = event.value if isinstance(event, yaml.ScalarEvent) and event.implicit[0] else ""
        if plain == "<<":
            self._fault(position, "merge keys '<<' are not supported", remedy="Write the entries out.")
            self.loader.get_event()
            return None
        before = len(self.faults)
        key = self._value((*path, _NOWHERE), depth + 1)
        del self.positions[(*path, _NOWHERE)]
        if isinstance(key, str):
            return key
        if len(self.faults) == before:
            self._fault(
                position, f"a key is {_kind(key)}", "text", f'Write "{plain}" in quotes.' if plain else ""
            )
        return None

    def _scalar(self, event: yaml.ScalarEvent, path: tuple[str | int, ...], position: Position) -> Any:
        text = event.value
        if found := _NOT_STORABLE.search(text):
            self._fault(position, f"text holds the character {found[0]!r}, which no file can")
            self.unread.add(path)
            return None
        if not event.implicit[0]:  # quoted or block text
            return text
        try:
            return plain_scalar(text)
        except ValueError as error:
            self._fault(position, str(error), "a finite number" if len(text) < LONGEST_NUMBER else "")
            self.unread.add(path)
            return None


def _height(value: Any) -> int:
    """Levels of mappings and lists below a value."""
    inside = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return 1 + max(map(_height, inside), default=-1)


def _kind(value: Any) -> str:
    if value is None:
        return "empty"
    names = {dict: "a mapping", list: "a list", bool: f"the boolean {value}"}
    return names.get(type(value), f"the number {value}")
