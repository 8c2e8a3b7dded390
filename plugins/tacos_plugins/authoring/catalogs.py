"""``tacos catalog``: what there is to choose from, and what is not known about it."""

from __future__ import annotations

from tacos_framework import (
    Catalog,
    CatalogPart,
    OffTheShelf,
    camera_names,
    catalog_names,
    find_catalog,
    load_cameras,
)

CAMERAS = "cameras"
"""The catalog of whole cameras, which are compared with and not chosen from."""

WEAK = ("derived", "hobby list")
"""Grades of values to ask the maker about before buying."""


def list_catalogs() -> str:
    """The shipped catalogs, a line each."""
    lines = [f"{CAMERAS:<22} {len(camera_names()):>4} cameras  Off the shelf, to compare designs with"]
    for name in catalog_names():
        catalog = find_catalog(name)
        lines.append(f"{name:<22} {len(catalog.rows):>4} parts    {catalog.title}")
    return "\n".join(lines)


def show_catalog(name: str) -> str:
    """A catalog as a table with units.

    ``?`` stands for what no source states, ``*`` for a doubtful row, ``~`` for a value that was derived from
    others or that only hobbyists state.
    """
    if name == CAMERAS:
        return "\n\n".join(_camera(camera) for camera in load_cameras(camera_names()))
    catalog = find_catalog(name)
    header = ["name", *(_heading(catalog, column.name) for column in catalog.columns)]
    rows = [[_name(part), *(_cell(part, c.name) for c in catalog.columns)] for part in catalog.rows]
    widths = [max(len(row[i]) for row in [header, *rows]) for i in range(len(header))]
    table = [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in [header, *rows]
    ]
    doubts = [f"* {part.name}: {doubt}" for part in catalog.rows for doubt in part.doubts]
    weak = [g for part in catalog.rows for g in part.grades.values() if g in WEAK]
    legend = [f"~ {' or '.join(sorted(set(weak)))}"] if weak else []
    return "\n".join([catalog.title, "", *table, "", *doubts, *legend, f"Source: {catalog.source}"])


def _camera(camera: OffTheShelf) -> str:
    fixes = [f"  {name}: {value}" for name, value in camera.fixes.items()]
    notes = [f"  note: {note}" for note in camera.notes]
    sources = [f"  source: {source}" for source in camera.sources]
    return "\n".join([f"{camera.name}: {camera.title} ({camera.rig})", *fixes, *notes, *sources])


def _heading(catalog: Catalog, name: str) -> str:
    unit = next(column.unit for column in catalog.columns if column.name == name)
    return name if unit in ("1", "") or name.endswith(f"_{unit}") else f"{name} [{unit}]"


def _name(part: CatalogPart) -> str:
    return f"{part.name}*" if part.doubts else part.name


def _cell(part: CatalogPart, column: str) -> str:
    value = part[column]
    if value is None:
        return "?"
    mark = "~" if part.grades.get(column) in WEAK else ""
    return f"{value:g}{mark}" if isinstance(value, float) else f"{value}{mark}"
