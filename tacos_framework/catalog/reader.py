"""Catalogs of parts in files: YAML with columns, provenance and doubts, or a plain table (CSV)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, TypeVar

from pydantic import ConfigDict

from tacos_framework.catalog.checks import (
    CatalogCell,
    PartChecker,
    RawPart,
    checked_value,
    column_called,
    unit_of,
)
from tacos_framework.catalog.parts import Catalog, CatalogColumn, Scheme
from tacos_framework.errors import Fault, UserError, did_you_mean
from tacos_framework.files import CSV_SUFFIXES, read_csv
from tacos_framework.packaged_resources import find_file, shipped_folder, shipped_names
from tacos_framework.settings import Settings, check, setting
from tacos_framework.settings.yaml_document import Document
from tacos_framework.settings.yaml_reader import read_yaml
from tacos_framework.values.catalog_part import CatalogPart, Grade

SIZES = ("width_mm", "height_mm", "pixel_um")
"""Columns that span the space of image sensors (paper, Sec. 4.3): width, height and pixel pitch."""

CAMERAS = "cameras"
"""The catalog of whole cameras: its name, and the key of those that fix variables of a rig."""

_Read = TypeVar("_Read")
_ROWS = ("parts", CAMERAS)
_RELATIVE_UNITS = ("%", "dB")


class ColumnEntry(Settings):
    """A column in the head of a YAML catalog."""

    help: str = setting(help="Meaning of its values, in one sentence.", min_length=1)
    unit: str | None = setting(None, help="Its unit; by default what the end of the name says.")
    type: Literal["number", "integer", "text"] = setting("number", help="Type of its values.")
    required: bool = setting(False, help="Require a value of each part.")
    positive: bool = setting(True, help="Require numbers above 0.")


class SourceEntry(Settings):
    """A source that values and parts name by its key."""

    title: str = setting(help="The source, in full.", min_length=1)
    grade: Grade | None = setting(None, help="Grade of its source.")


class InheritEntry(Settings):
    """Values a row leaves open that are those of the part it names, as a camera's are its sensor's."""

    model_config = ConfigDict(populate_by_name=True)

    by: str = setting(help="The column with the part's name.")
    catalogs: tuple[str, ...] = setting(help="Shipped catalogs to look it up in.", alias="from", min_length=1)
    columns: tuple[str, ...] = setting(help="The columns.", min_length=1)


class Head(Settings):
    """A YAML catalog, except for its parts."""

    title: str = setting(help="One line for people.", min_length=1)
    source: str = setting(help="Source of the values that name none of their own.", min_length=1)
    grade: Grade | None = setting(None, help="Grade of the source of those values.")
    sources: dict[str, SourceEntry] = setting({}, help="Sources that stand for many values.")
    licence: str = setting("", help="Terms of use.")
    columns: dict[str, ColumnEntry] = setting(help="The columns.", min_length=1)
    design_columns: tuple[str, ...] | None = setting(
        None, help="Columns of numbers that span the space a design moves in."
    )
    scheme: Scheme = setting(
        "quantized", help="Encoding of the rows for optimizers, unless a recipe states one."
    )
    rigs: dict[str, str] = setting(
        {}, help="Of whole cameras, the rig that takes each kind, as in {mono: rig.monocular}."
    )
    inherits: InheritEntry | None = setting(None, help="Values that rows take from rows of other catalogs.")


class PartEntry(Settings):
    """Keys of a part beside its values."""

    source: str | None = setting(None, help="Source of its values.")
    grade: Grade | None = setting(None, help="Grade of their source.")
    doubts: tuple[str, ...] = setting((), help="Probable faults.")
    notes: tuple[str, ...] = setting((), help="Anything else.")


class ValueEntry(Settings):
    """A value with its own source: ``full_well_e: {value: 11000, source: ..., grade: measurement}``."""

    value: float | str = setting(help="The value.")
    source: str = setting(help="Source.", min_length=1)
    grade: Grade | None = setting(None, help="Grade of its source.")


def catalog_names() -> tuple[str, ...]:
    return tuple(name for name in shipped_names(shipped_folder("catalogs")) if name != CAMERAS)


def find_catalog(name: str | Path, folder: Path | None = None) -> Catalog:
    """A shipped catalog by its name, or one of the user's by its path.

    `name`: ``image_sensors``, or a path of a YAML or CSV file. `folder`: the folder of the recipe: its paths
    start there and must not leave it. None lifts that.

    Raises `UserError` when there is none, or with all that is wrong with it.
    """
    return read_catalog(find_file(name, shipped_folder("catalogs"), folder=folder, noun="catalog"))


def read_catalog(path: Path) -> Catalog:
    """The catalog in a YAML or CSV file.

    Raises `UserError` with every fault that can be found in one pass.
    """
    return once_per_version(path, _read)


def once_per_version(path: Path, read: Callable[[Path], _Read]) -> _Read:
    """What `read` makes of a file, kept until the file changes: a study asks for one catalog many times."""
    try:
        stat = path.stat()
    except OSError:
        return read(path)  # which says what is wrong
    return _kept(path, stat.st_mtime_ns, stat.st_size, read)


@lru_cache(maxsize=32)
def _kept(path: Path, _mtime_ns: int, _size: int, read: Callable[[Path], Any]) -> Any:
    return read(path)


def _read(path: Path) -> Catalog:
    if path.suffix.lower() in CSV_SUFFIXES:
        return _from_csv(path)
    return _from_yaml(path.stem, read_yaml(path))


def _from_yaml(name: str, document: Document) -> Catalog:
    data = document.data
    if not isinstance(data, dict) or not isinstance(data.get("parts"), dict):
        expected = "a mapping with title, source, columns and parts"
        raise UserError(Fault(document.where(("parts",)), "this is no catalog of parts", expected))
    head, faults, _ = check(Head, {k: v for k, v in data.items() if k not in _ROWS}, document.where)
    if head is None:
        raise UserError(faults)
    columns = [_column(document, name, entry, faults) for name, entry in head.columns.items()]
    raws = []
    for part, entry in data["parts"].items():
        if isinstance(entry, dict):
            raws.append(_raw_part(document, part, entry, head, faults))
        else:
            where = document.where(("parts", part))
            faults.append(Fault(where, f"part {part} has no values", "a mapping from columns to values"))
    design_columns = head.design_columns
    if design_columns is not None:
        numeric = [c.name for c in (*columns, *_implied_sizes(columns)) if c.type != "text"]
        for i, column_name in enumerate(design_columns):
            if column_name not in numeric:
                what = f"there is no column of numbers {column_name!r}"
                where = document.where(("design_columns", i))
                faults.append(Fault(where, what, "", did_you_mean(column_name, numeric)))
    found = _catalog(
        name, head.title, head.source, columns, raws, design_columns, faults, document.where(("parts",))
    )
    rows = found.rows if head.inherits is None else tuple(_inheriting(found.rows, head.inherits))
    return replace(found, rows=rows, scheme=head.scheme, rigs=head.rigs)


def _inheriting(rows: Sequence[CatalogPart], inherits: InheritEntry) -> Iterator[CatalogPart]:
    """The rows with what the parts they name know, each value with its own source and grade."""
    known = {part.name: part for name in inherits.catalogs for part in find_catalog(name).rows}
    for row in rows:
        part = known.get(str(row.values.get(inherits.by)))
        taken = [
            c
            for c in inherits.columns
            if part and row.values.get(c) is None and part.values.get(c) is not None
        ]
        yield (
            row
            if part is None
            else replace(
                row,
                values={**row.values, **{c: part.values[c] for c in taken}},
                provenance={**row.provenance, **{c: part.provenance[c] for c in taken}},
                grades={**row.grades, **{c: part.grades[c] for c in taken if c in part.grades}},
            )
        )


def _column(document: Document, name: str, entry: ColumnEntry, faults: list[Fault]) -> CatalogColumn:
    implied = unit_of(name)
    unit = entry.unit or implied or "1"
    if implied and unit != implied:
        where = document.where(("columns", name, "unit"))
        faults.append(
            Fault(where, f"the unit of {name} is {unit}", implied, "Let the name end in the unit it has.")
        )
    return CatalogColumn(name, unit, entry.help, entry.type, entry.required, entry.positive)


def _raw_part(
    document: Document, name: str, entry: dict[str, Any], head: Head, faults: list[Fault]
) -> RawPart:
    path = ("parts", name)
    where = document.where(path)
    own = {key: value for key, value in entry.items() if key in PartEntry.model_fields}
    about, found, _ = check(PartEntry, own, lambda tail: document.where((*path, *tail)))
    faults += found
    about = about or PartEntry()
    cells = {
        key: _cell(document, (*path, key), value, head, faults)
        for key, value in entry.items()
        if key not in own
    }
    source, grade = _source(head, about.source, about.grade)
    if about.source is None:
        source, grade = head.source, about.grade or head.grade
    return RawPart(name, where, cells, source, about.doubts, about.notes, grade)


def _source(head: Head, source: str | None, grade: Grade | None) -> tuple[str, Grade | None]:
    """A source in full and its grade, where it may be the key of one that the head names."""
    named = head.sources.get(source or "")
    return (named.title, grade or named.grade) if named else (source or "", grade)


def _cell(
    document: Document, path: tuple[str, ...], given: Any, head: Head, faults: list[Fault]
) -> CatalogCell:
    """A value alone, or ``{value: ..., source: ...}``."""
    where = document.where(path)
    if not isinstance(given, dict):
        return CatalogCell(given, where)
    entry, found, _ = check(ValueEntry, given, lambda tail: document.where((*path, *tail)))
    faults += found
    if entry is None:
        return CatalogCell(None, where, refused=True)
    source, grade = _source(head, entry.source, entry.grade)
    return CatalogCell(entry.value, where, source, grade=grade)


def _from_csv(path: Path) -> Catalog:
    """A table whose first line names the columns: ``name``, and names that end in their unit."""
    lines = read_csv(path)
    first = lines[0][1] if lines else []
    heading = [column_called(each) for each in first]
    while heading and not heading[-1]:  # spreadsheets leave empty columns at the end
        heading.pop()
    if "name" not in heading:
        what = f"the first line names no column 'name', but {', '.join(first) or 'nothing'}"
        expected = "name, then columns that end in their unit, as in pixel_um"
        raise UserError(Fault(f"{path}:1", what, expected))
    faults = [
        Fault(f"{path}:1", f"column {name!r} stands here more than once", remedy="Remove one.")
        for name in sorted({name for name in heading if heading.count(name) > 1})
    ]
    raws = []
    for number, line in lines[1:]:
        if not any(line):
            continue
        where = f"{path}:{number}"
        if len(line) < len(heading) or any(line[len(heading) :]):
            faults.append(
                Fault(where, f"this line has {len(line)} values", f"{len(heading)}, as the first line")
            )
            continue
        raws.append(_raw_line(where, dict(zip(heading, line, strict=False)), path.name, faults))
        if not raws[-1].name:
            faults.append(Fault(where, "this part has no name"))
    columns = [_csv_column(name, raws) for name in heading if name not in ("name", *PartEntry.model_fields)]
    return _catalog(path.stem, path.stem, path.name, columns, raws, None, faults, f"{path}:1")


def _raw_line(where: str, cells: Mapping[str, str], source: str, faults: list[Fault]) -> RawPart:
    own = ("name", *PartEntry.model_fields)
    graded, found, _ = check(PartEntry, {"grade": cells.get("grade") or None}, lambda _: where)
    faults += found
    return RawPart(
        cells["name"],
        where,
        {name: CatalogCell(value, where) for name, value in cells.items() if name not in own},
        cells.get("source") or source,
        tuple(filter(None, [cells.get("doubts")])),
        tuple(filter(None, [cells.get("notes")])),
        graded and graded.grade,
    )


def _csv_column(name: str, raws: Sequence[RawPart]) -> CatalogColumn:
    """A column as its name says: pixels are whole; no unit and any word makes it text.

    What is relative may be negative, as the distortion of a barrel is.
    """
    unit = unit_of(name)
    if unit is not None:
        kind: Literal["integer", "number"] = "integer" if unit == "px" else "number"
        return CatalogColumn(name, unit, f"{name} of the table.", kind, positive=unit not in _RELATIVE_UNITS)
    plain = CatalogColumn(name, "1", f"{name} of the table.", positive=False)
    values = [raw.cells[name].value for raw in raws if raw.cells[name].value not in ("", "unknown")]
    if values and not any(checked_value(plain, value)[1] for value in values):
        return plain
    return CatalogColumn(name, "1", f"{name} of the table.", "text")


def _catalog(
    name: str,
    title: str,
    source: str,
    columns: Sequence[CatalogColumn],
    raws: Sequence[RawPart],
    design_columns: tuple[str, ...] | None,
    faults: Sequence[Fault],
    where: str,
) -> Catalog:
    columns = (*columns, *_implied_sizes(columns))
    checker = PartChecker(columns, list(faults))
    parts = checker.parts(raws)
    if not parts and not faults:
        checker.faults.append(Fault(where, "the catalog is empty", "at least one part"))
    if checker.faults:
        raise UserError(checker.faults)
    numeric = [column.name for column in columns if column.type != "text"]
    if design_columns is None:
        known = tuple(name for name in numeric if all(part.values[name] is not None for part in parts))
        design_columns = SIZES if set(SIZES) <= set(numeric) else known
    return Catalog(name, title, columns, parts, source, design_columns)


def _implied_sizes(columns: Sequence[CatalogColumn]) -> list[CatalogColumn]:
    """Columns of sizes in mm, where the file has pixels and their pitch but not these."""
    have = {column.name for column in columns}
    sizes = (name for name in SIZES if name not in have and name.replace("_mm", "_px") in have)
    return [CatalogColumn(name, "mm", "Pixels times their pitch.") for name in sizes if "pixel_um" in have]
