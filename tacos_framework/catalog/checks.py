"""From the cells of a file to parts: values checked against their column, doubts where sizes clash."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from tacos_framework.catalog.parts import CatalogColumn
from tacos_framework.catalog.plausible import implausible
from tacos_framework.errors import Fault, did_you_mean
from tacos_framework.values.catalog_part import CatalogPart, Grade, Value

CURRENCIES = ("eur", "usd", "gbp", "chf", "jpy", "cny")
"""Currencies of prices, as columns end in them (ISO 4217)."""

UNITS = {
    "px": "px",
    "nm": "nm",
    "um": "um",
    "mm": "mm",
    "cm": "cm",
    "m": "m",
    "deg": "deg",
    "us": "us",
    "ms": "ms",
    "s": "s",
    "e": "e-",
    "e_s": "e-/s",
    "dn": "DN",
    "db": "dB",
    "lux": "lux",
    "g": "g",
    "w": "W",
    "fps": "1/s",
    "percent": "%",
    **{currency: currency.upper() for currency in CURRENCIES},
}
"""The unit that the end of a column's name stands for: ``pixel_um`` is in um."""

_ENDS = {**{unit.lower(): end for end, unit in UNITS.items()}, **{end: end for end in UNITS}}
_HEADING = re.compile(r"(.*\S)\s*[\[(]([^\])]+)[\])]")
"""A heading with its unit in brackets."""
_SAME = {"pixel_size_um": "pixel_um", "pixel_pitch_um": "pixel_um"}
"""Other words for columns."""

SIZE_TOLERANCE = 0.01
"""Relative difference above which a size and its pixels times their pitch are said to clash."""

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")


@dataclass(frozen=True)
class CatalogCell:
    """A value as the file gives it, where it stands, and who says so where the file says.

    ``refused`` cells are at fault already, and no more is said about them.
    """

    value: Any
    where: str
    source: str | None = None
    refused: bool = False
    grade: Grade | None = None


@dataclass(frozen=True)
class RawPart:
    """A row of a file, before its values are checked."""

    name: str
    where: str
    cells: Mapping[str, CatalogCell]
    source: str
    doubts: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    grade: Grade | None = None


@dataclass
class PartChecker:
    """Turns raw parts into parts and keeps every fault."""

    columns: Sequence[CatalogColumn]
    faults: list[Fault] = field(default_factory=list)

    def parts(self, raws: Sequence[RawPart]) -> tuple[CatalogPart, ...]:
        """The parts in their order; what is wrong with them is in `faults`."""
        self._refuse_duplicates(raws)
        parts: list[CatalogPart] = []
        for raw in raws:
            part = self._part(raw)
            twin = next((p for p in parts if p.values == part.values), None)
            if twin is not None:
                doubt = f"All values are those of {twin.name}."
                part = replace(part, doubts=(*part.doubts, doubt))
            parts.append(part)
        return tuple(parts)

    def _refuse_duplicates(self, raws: Sequence[RawPart]) -> None:
        seen: dict[str, RawPart] = {}
        for raw in raws:
            first = seen.setdefault(raw.name.casefold(), raw)
            if first is not raw:
                what = f"part {raw.name!r} stands here again, first at {first.where}"
                self.faults.append(Fault(raw.where, what, remedy="Remove one, or name them apart."))

    def _part(self, raw: RawPart) -> CatalogPart:
        names = [column.name for column in self.columns]
        for name, cell in raw.cells.items():
            if name not in names:
                what = f"{raw.name} has a value for {name!r}, which is no column"
                self.faults.append(Fault(cell.where, what, "", did_you_mean(name, names)))
        values: dict[str, Value] = {}
        provenance: dict[str, str] = {}
        grades: dict[str, Grade] = {}
        for column in self.columns:
            given = raw.cells.get(column.name)
            values[column.name] = self._value(raw, column, given)
            if given is not None and values[column.name] is not None:
                provenance[column.name] = given.source or raw.source
                if grade := given.grade or (raw.grade if given.source is None else None):
                    grades[column.name] = grade
        doubts = (*raw.doubts, *_settle_sizes(values, provenance), *implausible(values))
        return CatalogPart(raw.name, values, provenance, doubts, raw.notes, grades)

    def _value(self, raw: RawPart, column: CatalogColumn, cell: CatalogCell | None) -> Value:
        if cell is not None and cell.refused:
            return None
        if cell is None or cell.value is None or cell.value in ("", "unknown"):
            if column.required:
                where = raw.where if cell is None else cell.where
                self.faults.append(
                    Fault(
                        where,
                        f"{raw.name} has no {column.name}",
                        f"{column.help.rstrip('.')} [{column.unit}]",
                    )
                )
            return None
        value, complaint, remedy = checked_value(column, cell.value)
        if complaint:
            expected = f"{_ARTICLES[column.type]} [{column.unit}]" if column.type != "text" else "text"
            self.faults.append(
                Fault(cell.where, f"{column.name} of {raw.name} is {complaint}", expected, remedy)
            )
        return value


_ARTICLES = {"number": "a number", "integer": "a whole number", "text": "text"}


def checked_value(column: CatalogColumn, given: Any) -> tuple[Value, str, str]:
    """A value fit for the column, or None with what is wrong and what to do.

    Text that is a number counts as one, as files of comma-separated values have nothing but text.
    """
    if column.type == "text":
        if isinstance(given, str):
            return given, "", ""
        return None, repr(given), f'Write "{given}" in quotes.'
    if isinstance(given, str) and _NUMBER.fullmatch(given.strip()):
        given = float(given)
    if isinstance(given, str) and _NUMBER.match(given.strip()):
        return None, repr(given), f"Write the number alone; the column is in {column.unit}."
    if isinstance(given, bool) or not isinstance(given, int | float):
        return None, repr(given), "Leave it out, or write unknown, where no source states it."
    if not math.isfinite(given):
        return None, str(given), "Leave it out, or write unknown, where no source states it."
    if column.positive and given <= 0:
        return None, f"{given:g}, which is not above 0", ""
    if column.type == "integer":
        if given != int(given):
            return None, f"{given:g}, which is not whole", ""
        return int(given), "", ""
    return float(given), "", ""


def column_called(heading: str) -> str:
    """The name of a column whose heading has capitals, blanks, or its unit in brackets.

    >>> column_called("Pixel size [um]"), column_called("WIDTH_PX"), column_called("read noise (e-)")
    ('pixel_um', 'width_px', 'read_noise_e')
    """
    name = re.sub("[\u00b5\u03bc]", "u", heading.lower())
    if (found := _HEADING.fullmatch(name)) and (end := _ENDS.get(found[2])):
        name = f"{found[1]}_{end}"
    name = re.sub(r"\s+", "_", name)
    return _SAME.get(name, name)


def unit_of(name: str) -> str | None:
    """The unit the end of a column's name stands for; None where it names none."""
    return _stem_and_unit(name)[1]


def in_words(column: str) -> str:
    """A column's name for sentences.

    >>> in_words("full_well_e"), in_words("dark_current_e_s"), in_words("colour")
    ('full well [e-]', 'dark current [e-/s]', 'colour')
    """
    stem, unit = _stem_and_unit(column)
    return stem.replace("_", " ") + (f" [{unit}]" if unit else "")


def _stem_and_unit(name: str) -> tuple[str, str | None]:
    words = name.split("_")
    for count in (2, 1):
        if len(words) > count and (unit := UNITS.get("_".join(words[-count:]).lower())):
            return "_".join(words[:-count]), unit
    return name, None


def _settle_sizes(values: dict[str, Value], provenance: dict[str, str]) -> list[str]:
    """Fill sizes in mm that follow from pixels and their pitch; doubt those that contradict them."""
    doubts = []
    pitch = values.get("pixel_um")
    for name, size in list(values.items()):
        pixels = values.get(name.replace("_mm", "_px"))
        if not name.endswith("_mm") or not isinstance(pitch, float) or not isinstance(pixels, int):
            continue
        computed = round(pixels * pitch * 1e-3, 6)
        if size is None:
            values[name] = computed
            provenance[name] = f"{name.replace('_mm', '_px')} x pixel_um"
        elif isinstance(size, float) and abs(size - computed) > SIZE_TOLERANCE * computed:
            doubts.append(f"{name} is {size:g}, but {pixels} pixels of {pitch:g} um are {computed:g} mm.")
    return doubts
