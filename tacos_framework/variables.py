"""Design variables: what each may be, and how it looks to an optimizer.

Every variable turns the numbers of an optimizer into a value that can be manufactured, and back. Constructors
refuse what makes no sense with a `ValueError` that says so in a sentence.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from tacos_framework.catalog.parts import Catalog, Part
from tacos_framework.errors import did_you_mean

LARGEST_INTEGER = 2**53
"""Beyond it, whole numbers are no longer told apart as float64 genes."""


@dataclass(frozen=True)
class Gene:
    """One number an optimizer varies.

    Parameters
    ----------
    name
        The variable's name, followed by the column for catalog variables: ``sensor.pixel_um``.
    variable
        The variable it belongs to.
    kind
        ``continuous``; ``integer``; or ``choice``, an index 0, 1, ... ``upper``.
    lower, upper
        Bounds, both included, in the unit of the variable.
    """

    name: str
    variable: str
    kind: Literal["continuous", "integer", "choice"]
    lower: float
    upper: float


class Variable(Protocol):
    """What the design space asks of a variable. Genes are its own, inside their bounds."""

    @property
    def name(self) -> str:
        """The name recipes use."""
        ...

    @property
    def genes(self) -> tuple[Gene, ...]:
        """The genes it needs."""
        ...

    def decode(self, genes: Sequence[float]) -> tuple[Any, tuple[float, ...]]:
        """The nearest value that can be manufactured, and the genes of exactly that value."""
        ...

    def encode(self, value: Any) -> tuple[float, ...]:
        """The genes of a value; ValueError for a value this variable cannot have."""
        ...

    def draw(self, rng: np.random.Generator) -> tuple[float, ...]:
        """Genes drawn at random, evenly over the variable."""
        ...

    def as_data(self) -> dict[str, Any]:
        """Name, kind, unit and what it may be, as JSON values for results and reports."""
        ...


@dataclass(frozen=True)
class Continuous:
    """Any number between two bounds, both included."""

    name: str
    lower: float
    upper: float
    unit: str = "1"

    def __post_init__(self) -> None:
        _check_bounds(self)

    @property
    def genes(self) -> tuple[Gene, ...]:
        """One continuous gene."""
        return (Gene(self.name, self.name, "continuous", float(self.lower), float(self.upper)),)

    def decode(self, genes: Sequence[float]) -> tuple[float, tuple[float, ...]]:
        """The gene itself."""
        value = float(genes[0]) + 0.0  # -0.0 becomes 0.0, so that equal candidates have equal keys
        return value, (value,)

    def encode(self, value: Any) -> tuple[float, ...]:
        """The value itself."""
        _check_inside(self, value)
        return (float(value),)

    def draw(self, rng: np.random.Generator) -> tuple[float, ...]:
        """Uniform between the bounds."""
        return (rng.uniform(self.lower, self.upper),)

    def as_data(self) -> dict[str, Any]:
        """The variable as JSON values."""
        bounds = {"lower": self.lower, "upper": self.upper}
        return {"name": self.name, "kind": "continuous", "unit": self.unit, **bounds}


@dataclass(frozen=True)
class Integer:
    """Any whole number between two bounds, both included."""

    name: str
    lower: int
    upper: int
    unit: str = "1"

    def __post_init__(self) -> None:
        _check_bounds(self)
        for bound in (self.lower, self.upper):
            if bound != int(bound) or abs(bound) > LARGEST_INTEGER:
                raise ValueError(f"{self.name} is a whole number, so its bounds are, not {bound}")

    @property
    def genes(self) -> tuple[Gene, ...]:
        """One integer gene."""
        return (Gene(self.name, self.name, "integer", float(self.lower), float(self.upper)),)

    def decode(self, genes: Sequence[float]) -> tuple[int, tuple[float, ...]]:
        """The nearest whole number."""
        value = round(float(genes[0]))
        return value, (float(value),)

    def encode(self, value: Any) -> tuple[float, ...]:
        """The value itself."""
        _check_inside(self, value)
        if value != int(value):
            raise ValueError(f"{self.name} is a whole number, not {value}")
        return (float(value),)

    def draw(self, rng: np.random.Generator) -> tuple[float, ...]:
        """Each whole number alike."""
        return (float(rng.integers(int(self.lower), int(self.upper), endpoint=True)),)

    def as_data(self) -> dict[str, Any]:
        """The variable as JSON values."""
        bounds = {"lower": self.lower, "upper": self.upper}
        return {"name": self.name, "kind": "integer", "unit": self.unit, **bounds}


@dataclass(frozen=True)
class Categorical:
    """One of some values without order; text, numbers or booleans."""

    name: str
    values: tuple[Any, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", tuple(self.values))
        if not self.values:
            raise ValueError(f"{self.name} needs at least one value to choose from")
        tagged = [_tagged(value) for value in self.values]
        if repeated := sorted({repr(value) for value in self.values if tagged.count(_tagged(value)) > 1}):
            raise ValueError(f"{self.name} names {', '.join(repeated)} more than once")

    @property
    def genes(self) -> tuple[Gene, ...]:
        """One index into the values."""
        return (Gene(self.name, self.name, "choice", 0.0, float(len(self.values) - 1)),)

    def decode(self, genes: Sequence[float]) -> tuple[Any, tuple[float, ...]]:
        """The value of the nearest index."""
        index = round(float(genes[0]))
        return self.values[index], (float(index),)

    def encode(self, value: Any) -> tuple[float, ...]:
        """The index of the value; the boolean True and the number 1 are different values."""
        tagged = [_tagged(known) for known in self.values]
        if _tagged(value) not in tagged:
            raise ValueError(f"{self.name} is one of {', '.join(map(repr, self.values))}, not {value!r}")
        return (float(tagged.index(_tagged(value))),)

    def draw(self, rng: np.random.Generator) -> tuple[float, ...]:
        """Each value alike."""
        return (float(rng.integers(len(self.values))),)

    def as_data(self) -> dict[str, Any]:
        """The variable as JSON values."""
        return {"name": self.name, "kind": "categorical", "unit": "", "values": list(self.values)}


@dataclass(frozen=True)
class CatalogChoice:
    """A part from a catalog, by one of the two schemes of the paper (Sec. 3.3).

    Parameters
    ----------
    name
        The name recipes use.
    catalog
        The catalog to choose from.
    scheme
        ``quantized``: one gene per column, and the nearest row afterwards (paper, eq. 2), so that parts
        alike are close. ``discrete``: one gene, the index of a row; rows are ordered by area, so that a
        step to the next index means something.
    columns
        Columns of numbers that span the space of parts; the catalog's `design_columns` if None.
    distance
        ``normalised`` divides each column by its range over the rows, so that no unit outweighs another;
        ``plain`` is the paper's, which adds squared millimetres and micrometres.

    Notes
    -----
    Parts without a known number in every one of the columns cannot be chosen; `left_out` holds them.
    """

    name: str
    catalog: Catalog
    scheme: Literal["quantized", "discrete"] = "quantized"
    columns: tuple[str, ...] | None = None
    distance: Literal["normalised", "plain"] = "normalised"

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
        places: dict[tuple[float, ...], Part] = {}
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
    def rows(self) -> tuple[Part, ...]:
        """The parts to choose from, ordered by area."""
        return tuple(sorted(self.catalog.rows_knowing(self.design_columns), key=self._order))

    @property
    def left_out(self) -> tuple[Part, ...]:
        """Parts of the catalog that cannot be chosen, as a number is unknown."""
        return tuple(part for part in self.catalog.rows if part not in self.rows)

    def _order(self, row: Part) -> tuple[float | str, ...]:
        """Area where the part has one, then the columns in turn, then the name."""
        numbers = (*(row.number(column) for column in self.design_columns), row.name)
        width, height = row.values.get("width_mm"), row.values.get("height_mm")
        if isinstance(width, int | float) and isinstance(height, int | float):
            return (width * height, *numbers)
        return (0.0, *numbers)

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

    def decode(self, genes: Sequence[float]) -> tuple[Part, tuple[float, ...]]:
        """The nearest part."""
        if self.scheme == "discrete":
            index = round(float(genes[0]))
        else:
            offsets = (self._table - np.asarray(genes)) / self._scale
            index = int(np.argmin((offsets**2).sum(axis=1)))  # (eq. 2)
        return self.rows[index], self._genes_of(index)

    def encode(self, value: Any) -> tuple[float, ...]:
        """The genes of a part, given as a `Part`, its `Part.as_dict`, or its name."""
        name = value.name if isinstance(value, Part) else value
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
            "scheme": self.scheme,
            "columns": list(self.design_columns),
            "distance": self.distance,
        }

    def _genes_of(self, index: int) -> tuple[float, ...]:
        if self.scheme == "discrete":
            return (float(index),)
        return tuple(map(float, self._table[index]))


def _check_bounds(variable: Continuous | Integer) -> None:
    lower, upper = variable.lower, variable.upper
    if not (math.isfinite(lower) and math.isfinite(upper)):
        raise ValueError(f"bounds of {variable.name} must be finite numbers, not {lower} and {upper}")
    if not lower < upper:
        raise ValueError(f"{variable.name} is between {lower} and {upper}: the lower bound must come first")


def _check_inside(variable: Continuous | Integer, value: Any) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        raise ValueError(f"{variable.name} is a number, not {value!r}")
    if not variable.lower <= value <= variable.upper:
        unit = "" if variable.unit == "1" else f" {variable.unit}"
        raise ValueError(
            f"{variable.name} is {value}{unit}, outside of {variable.lower} to {variable.upper}{unit}"
        )


def _tagged(value: Any) -> tuple[bool, Any]:
    """Tells booleans from the numbers they equal."""
    return isinstance(value, bool), value
