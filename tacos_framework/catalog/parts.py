"""Parts, the columns that describe them, and catalogs of parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from tacos_framework.errors import did_you_mean

Value = float | int | str | None
"""A value of a part; None where no source states it."""

Grade = Literal[
    "data sheet", "camera maker", "measurement", "transcription", "reseller", "derived", "hobby list"
]
"""How far a value can be trusted, the best first: stated by the maker of the part; by the maker of a camera
with it (EMVA 1288, a manual); measured by somebody who says how; one of these as copied by a third party;
stated by a shop; computed from other values; said by a list or program not checked against the maker."""


@dataclass(frozen=True)
class CatalogColumn:
    """What the values of one column mean.

    Parameters
    ----------
    name
        Ends in the unit, as in ``pixel_um``; words have none.
    unit
        The unit as it is written for people (``"um"``, ``"e-/s"``); ``"1"`` for ratios and words.
    type
        ``number``, ``integer`` or ``text``.
    required
        Whether each part must have a value.
    positive
        Whether numbers must be above 0.
    """

    name: str
    unit: str
    help: str
    type: Literal["number", "integer", "text"] = "number"
    required: bool = False
    positive: bool = True


@dataclass(frozen=True)
class CatalogPart:
    """A part that can be bought: one row of a catalog.

    Parameters
    ----------
    name
        Unique in its catalog.
    values
        For each column its value; None is unknown.
    provenance
        For each known value, who says so.
    doubts
        Sentences about values that are probably wrong.
    notes
        Sentences on anything else, such as what was cross-checked.
    grades
        How far a value can be trusted, where the catalog says so.
    """

    name: str
    values: Mapping[str, Value]
    provenance: Mapping[str, str] = field(default_factory=dict, compare=False)
    doubts: tuple[str, ...] = field(default=(), compare=False)
    notes: tuple[str, ...] = field(default=(), compare=False)
    grades: Mapping[str, Grade] = field(default_factory=dict, compare=False)

    def __hash__(self) -> int:
        return hash((self.name, frozenset(self.values.items())))

    def __getitem__(self, column: str) -> Value:
        return self.values[column]

    def number(self, column: str) -> float:
        """A value that must be a number.

        Raises
        ------
        ValueError
            When it is unknown or text.
        """
        value = self.values.get(column)
        if isinstance(value, int | float):
            return float(value)
        found = "unknown" if value is None else repr(value)
        raise ValueError(f"{column} of {self.name} is {found}, and a number is needed")

    def as_dict(self) -> dict[str, Value]:
        """Name and values, as JSON values."""
        return {"name": self.name, **self.values}


@dataclass(frozen=True)
class Catalog:
    """Parts of one kind to choose from.

    Parameters
    ----------
    name
        What recipes call it.
    title
        One line for people.
    columns
        What is known of its parts.
    rows
        The parts, in the order of the file.
    source
        Where the catalog as a whole comes from.
    design_columns
        The numeric columns that span the space a design moves in, unless the recipe says otherwise.
    """

    name: str
    title: str
    columns: tuple[CatalogColumn, ...]
    rows: tuple[CatalogPart, ...]
    source: str
    design_columns: tuple[str, ...]

    def __post_init__(self) -> None:
        if not self.rows:
            raise ValueError(f"catalog {self.name} has no parts")
        names = [row.name for row in self.rows]
        if repeated := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"catalog {self.name} has more than one part called {', '.join(repeated)}")

    def part(self, name: str) -> CatalogPart:
        """The part of that name.

        Raises
        ------
        ValueError
            When there is none.
        """
        for row in self.rows:
            if row.name == name:
                return row
        remedy = did_you_mean(name, (row.name for row in self.rows))
        raise ValueError(f"catalog {self.name} has no part {name!r}. {remedy}")

    def rows_knowing(self, columns: Sequence[str]) -> tuple[CatalogPart, ...]:
        """The rows whose value is known in all of these columns: those that can be designed with."""
        return tuple(row for row in self.rows if all(row.values.get(name) is not None for name in columns))
