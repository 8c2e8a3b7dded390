"""A part that can be bought, with what is known of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Value = float | int | str | None
"""A value of a part; None where no source states it."""

Grade = Literal[
    "data sheet",
    "camera maker",
    "driver code",
    "measurement",
    "transcription",
    "reseller",
    "derived",
    "hobby list",
]
"""Grades of trust in a value, the best first: stated by the maker of the part; by the maker of a camera
with it (EMVA 1288, a manual); written to the part by code that runs it, in one of its modes; measured by
somebody who says how; one of these as copied by a third party; stated by a shop; computed from other values;
said by a list or program not checked against the maker."""


@dataclass(frozen=True)
class CatalogPart:
    """A part that can be bought: one row of a catalog."""

    name: str
    """Unique in its catalog."""
    values: Mapping[str, Value]
    """For each column its value; None is unknown."""
    provenance: Mapping[str, str] = field(default_factory=dict, compare=False)
    """For each known value, who says so."""
    doubts: tuple[str, ...] = field(default=(), compare=False)
    """Sentences about values that are probably wrong."""
    notes: tuple[str, ...] = field(default=(), compare=False)
    """Sentences on anything else, such as what was cross-checked."""
    grades: Mapping[str, Grade] = field(default_factory=dict, compare=False)
    """Trust in a value, where the catalog grades it."""

    def __hash__(self) -> int:
        return hash((self.name, frozenset(self.values.items())))

    def __getitem__(self, column: str) -> Value:
        return self.values[column]

    def number(self, column: str) -> float:
        """A value that must be a number.

        Raises `ValueError` when it is unknown or text.
        """
        value = self.values.get(column)
        if isinstance(value, int | float):
            return float(value)
        found = "unknown" if value is None else repr(value)
        raise ValueError(f"{column} of {self.name} is {found}, and a number is needed")

    def as_dict(self) -> dict[str, Value]:
        """Name and values, as JSON values."""
        return {"name": self.name, **self.values}
