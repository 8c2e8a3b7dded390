"""Positions of the keys of a recipe that was read from a text."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tacos_framework.errors import Fault
from tacos_framework.settings.yaml_document import Document


class Written:
    """A recipe that may come from a text; one built in Python names its keys alone."""

    @property
    def text(self) -> Document | None:
        raise NotImplementedError

    def where(self, path: Sequence[str | int]) -> str:
        """File, line and column of a key; its dotted name for a recipe built in Python."""
        return ".".join(map(str, ("recipe", *path))) if self.text is None else self.text.where(tuple(path))

    def folder_of(self, path: Sequence[str | int]) -> Path | None:
        """The folder that a relative path at a key starts from; None for the working folder."""
        return None if self.text is None else self.text.folder_of(path)

    def without_echoes(self, faults: Sequence[Fault]) -> list[Fault]:
        """Without the faults of values that the text's reader has refused already."""
        return list(faults) if self.text is None else self.text.without_echoes(faults)
