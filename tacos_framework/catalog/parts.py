"""Catalogs of parts, and the columns that describe them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from tacos_framework.errors import did_you_mean
from tacos_framework.values.catalog_part import CatalogPart

Scheme = Literal["quantized", "discrete"]
"""Encoding of the rows of a catalog for optimizers (paper, Sec. 3.3)."""


@dataclass(frozen=True)
class CatalogColumn:
    """Unit, type and meaning of one column."""

    name: str
    """Ends in the unit, as in ``pixel_um``; words have none."""
    unit: str
    """The unit as it is written for people (``"um"``, ``"e-/s"``); ``"1"`` for ratios and words."""
    help: str
    type: Literal["number", "integer", "text"] = "number"
    """``number``, ``integer`` or ``text``."""
    required: bool = False
    positive: bool = True
    """True if numbers must be above 0."""


@dataclass(frozen=True)
class Catalog:
    """Parts of one kind to choose from."""

    name: str
    """The name in recipes."""
    title: str
    columns: tuple[CatalogColumn, ...]
    rows: tuple[CatalogPart, ...]
    """The parts, in the order of the file."""
    source: str
    """Source of the catalog as a whole."""
    design_columns: tuple[str, ...]
    """The numeric columns that span the space a design moves in, unless the recipe says otherwise."""
    scheme: Scheme = "quantized"
    """Encoding of its rows for optimizers, unless the recipe says otherwise (`CatalogChoice`)."""
    rigs: Mapping[str, str] = field(default_factory=dict, compare=False)
    """Of a catalog of whole cameras, the rig that takes each kind of them."""

    def __post_init__(self) -> None:
        if not self.rows:
            raise ValueError(f"catalog {self.name} has no parts")
        names = [row.name for row in self.rows]
        if repeated := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"catalog {self.name} has more than one part called {', '.join(repeated)}")

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(row.name for row in self.rows)

    def part(self, name: str) -> CatalogPart:
        """The part of that name.

        Raises `ValueError` when there is none.
        """
        for row in self.rows:
            if row.name == name:
                return row
        remedy = did_you_mean(name, (row.name for row in self.rows))
        raise ValueError(f"catalog {self.name} has no part {name!r}. {remedy}")
