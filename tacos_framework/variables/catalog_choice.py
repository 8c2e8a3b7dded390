"""A variable that is a part from a catalog."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tacos_framework.catalog.parts import Catalog
from tacos_framework.errors import did_you_mean
from tacos_framework.values.catalog_part import CatalogPart
from tacos_framework.variables.gene import Gene


@dataclass(frozen=True)
class CatalogChoice:
    """A part from a catalog, by one of the two schemes of the paper (Sec. 3.3).

    Parts without a known number in every one of the columns cannot be chosen either; `reasons` holds both.
    """

    name: str
    """The name recipes use."""
    catalog: Catalog
    scheme: Literal["quantized", "discrete"] = "quantized"
    """``quantized``: one gene per column, and the nearest row afterwards (paper, eq. 2), so that parts alike
    are close. ``discrete``: one gene, the index of a row; rows are ordered by area, so that a step to the
    next index means something.
    """
    columns: tuple[str, ...] | None = None
    """Columns of numbers that span the space of parts; the catalog's `design_columns` if None."""
    distance: Literal["normalised", "plain"] = "normalised"
    """``normalised`` divides each column by its range over the rows, so that no unit outweighs another;
    ``plain`` is the paper's, which adds squared millimetres and micrometres.
    """
    excluded: frozenset[str] = frozenset()
    """Names of parts that may not be chosen, as a constraint on one of their columns rules them out."""
    unfit: Mapping[str, str] = field(default_factory=dict, compare=False)
    """Parts that nothing can be built from, and why."""

    def __post_init__(self) -> None:
        if self.scheme not in ("quantized", "discrete"):
            raise ValueError(f"the scheme of {self.name} is quantized or discrete, not {self.scheme!r}")
        if self.distance not in ("normalised", "plain"):
            raise ValueError(f"the distance of {self.name} is normalised or plain, not {self.distance!r}")
        if not self.design_columns:
            raise ValueError(f"{self.name} needs at least one column of numbers")
        numeric = [column.name for column in self.catalog.columns if column.type != "text"]
        for column in self.design_columns:
            if column not in numeric:
                remedy = did_you_mean(column, numeric)
                raise ValueError(f"catalog {self.catalog.name} has no column of numbers {column!r}. {remedy}")
        if not self.rows:
            columns = ", ".join(self.design_columns)
            raise ValueError(f"no part of catalog {self.catalog.name} is known in {columns}")
        if self.scheme == "quantized":
            self._refuse_twins()

    def _refuse_twins(self) -> None:
        places: dict[tuple[float, ...], CatalogPart] = {}
        for row, place in zip(self.rows, map(tuple, self._table.tolist()), strict=True):
            other = places.setdefault(place, row)
            if other is not row:
                columns = ", ".join(self.design_columns)
                raise ValueError(
                    f"{self.name}: {other.name} and {row.name} are equal in {columns}, so neither is "
                    f"nearest; use scheme discrete, or a column that tells them apart"
                )

    @property
    def design_columns(self) -> tuple[str, ...]:
        """The columns that span the space of parts."""
        return self.catalog.design_columns if self.columns is None else tuple(self.columns)

    @cached_property
    def rows(self) -> tuple[CatalogPart, ...]:
        """The parts to choose from, ordered by area."""
        barred = {*self.reasons, *self.excluded}
        return tuple(sorted((row for row in self.catalog.rows if row.name not in barred), key=self._order))

    @cached_property
    def reasons(self) -> dict[str, str]:
        """Why each part that cannot be chosen cannot, whatever the constraints say."""
        found = {}
        for row in self.catalog.rows:
            unknown = [column for column in self.design_columns if row.values.get(column) is None]
            if unknown or row.name in self.unfit:
                found[row.name] = f"{' and '.join(unknown)} unknown" if unknown else self.unfit[row.name]
        return found

    @property
    def left_out(self) -> tuple[CatalogPart, ...]:
        """Parts of the catalog that cannot be chosen, for one of the `reasons`."""
        return tuple(part for part in self.catalog.rows if part.name in self.reasons)

    def _order(self, row: CatalogPart) -> tuple[float, tuple[float, ...], str]:
        """Area where the part has one, then the columns in turn, then the name."""
        width, height = row.values.get("width_mm"), row.values.get("height_mm")
        has_area = isinstance(width, int | float) and isinstance(height, int | float)
        area = row.number("width_mm") * row.number("height_mm") if has_area else 0.0
        return area, tuple(row.number(column) for column in self.design_columns), row.name

    @cached_property
    def _table(self) -> NDArray[np.float64]:
        """(rows, columns) numbers of the parts, in the units of the columns."""
        return np.array([[row.number(column) for column in self.design_columns] for row in self.rows])

    @cached_property
    def _scale(self) -> NDArray[np.float64]:
        """(columns,) what counts as a distance of one; a column in which all parts agree tells nothing."""
        span = np.ptp(self._table, axis=0)
        return np.where((span > 0) & (self.distance == "normalised"), span, 1.0)

    @property
    def genes(self) -> tuple[Gene, ...]:
        """One gene per column (quantized), or one index (discrete)."""
        if self.scheme == "discrete":
            return (Gene(self.name, self.name, "choice", 0.0, float(len(self.rows) - 1)),)
        lower, upper = self._table.min(axis=0), self._table.max(axis=0)
        return tuple(
            Gene(f"{self.name}.{column}", self.name, "continuous", float(low), float(high))
            for column, low, high in zip(self.design_columns, lower, upper, strict=True)
        )

    def decode(self, genes: Sequence[float]) -> tuple[CatalogPart, tuple[float, ...]]:
        """The nearest part."""
        if self.scheme == "discrete":
            index = round(float(genes[0]))
        else:
            offsets = (self._table - np.asarray(genes)) / self._scale
            index = int(np.argmin((offsets**2).sum(axis=1)))  # (eq. 2)
        return self.rows[index], self._genes_of(index)

    def encode(self, value: Any) -> tuple[float, ...]:
        """The genes of a part, given as a `CatalogPart`, its `CatalogPart.as_dict`, or its name."""
        name = value.name if isinstance(value, CatalogPart) else value
        if isinstance(value, Mapping):
            name = value.get("name")
        names = [row.name for row in self.rows]
        if name not in names:
            raise ValueError(f"{self.name} has no part {name!r}. {did_you_mean(str(name), names)}")
        return self._genes_of(names.index(name))

    def draw(self, rng: np.random.Generator) -> tuple[float, ...]:
        """Discrete: each part alike. Quantized: uniform in the box of the columns, as the paper starts."""
        if self.scheme == "discrete":
            return (float(rng.integers(len(self.rows))),)
        return tuple(rng.uniform(gene.lower, gene.upper) for gene in self.genes)

    def as_data(self) -> dict[str, Any]:
        """The variable as JSON values; ``values`` counts the parts that can be chosen."""
        return {
            "name": self.name,
            "kind": "catalog",
            "unit": "",
            "catalog": self.catalog.name,
            "values": len(self.rows),
            "left_out": [part.name for part in self.left_out],
            **({"excluded": sorted(self.excluded)} if self.excluded else {}),
            "scheme": self.scheme,
            "columns": list(self.design_columns),
            "distance": self.distance,
        }

    def _genes_of(self, index: int) -> tuple[float, ...]:
        if self.scheme == "discrete":
            return (float(index),)
        return tuple(map(float, self._table[index]))
