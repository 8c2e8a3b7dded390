"""``tacos catalog``: what there is to choose from, and what is not known about it."""

from __future__ import annotations

from dataclasses import replace

from tacos_framework import (
    Catalog,
    CatalogPart,
    Fault,
    OffTheShelf,
    UserError,
    camera_names,
    catalog_names,
    find_catalog,
    load_cameras,
)

CAMERAS = "cameras"
"""The catalog of whole cameras, which are compared with and chosen from."""

DECIDING = (
    "kind",
    "sensor",
    "width_px",
    "height_px",
    "pixel_um",
    "shutter",
    "colour",
    "hfov_deg",
    "f_number",
    "baseline_mm",
    "max_fps",
    "interface",
    "mass_g",
    "power_w",
    "price_usd",
)
"""Columns of whole cameras by which one is chosen; the others are shown of one at a time."""

WEAK = ("derived", "hobby list")
"""Grades of values to ask the maker about before buying."""


def list_catalogs() -> str:
    lines = [
        f"{CAMERAS:<22} {len(camera_names()):>4} cameras  Off the shelf, to compare with and choose from"
    ]
    for name in catalog_names():
        catalog = find_catalog(name)
        lines.append(f"{name:<22} {len(catalog.rows):>4} parts    {catalog.title}")
    return "\n".join(lines)


def show_catalog(name: str) -> str:
    """A catalog as a table with units; of whole cameras, the columns that decide.

    ``?`` stands for what no source states, ``*`` for a doubtful row, ``~`` for a value that was derived from
    others or that only hobbyists state.
    """
    if name != CAMERAS:
        return _table(find_catalog(name))
    catalog = find_catalog(name)
    kept = [column for column in catalog.columns if column.name in DECIDING]
    own = [camera for camera in load_cameras(camera_names()) if camera.name not in catalog.names]
    shown = _table(replace(catalog, columns=tuple(kept)), doubts=False)
    more = f"tacos catalog {CAMERAS} NAME shows all that is known of one, with sources and doubts."
    return "\n\n".join([shown, more, "Compared with by the paper:", *map(_camera, own)])


def show_part(name: str, part: str) -> str:
    """All that is known of a part, each value with its grade and source, and what is not known.

    Raises `UserError` where the catalog has no such part.
    """
    catalog = find_catalog(name)
    if name == CAMERAS and part in camera_names() and part not in catalog.names:
        return _camera(*load_cameras([part]))
    try:
        row = catalog.part(part)
    except ValueError as error:
        raise UserError(Fault(part, str(error))) from None
    known = [column for column in catalog.columns if row[column.name] is not None]
    cells = [
        (
            _heading(catalog, column.name),
            _cell(row, column.name),
            row.grades.get(column.name, ""),
            row.provenance.get(column.name, ""),
        )
        for column in known
    ]
    widths = [max(len(cell[i]) for cell in cells) for i in range(3)]
    lines = ["  ".join([*(cell[i].ljust(widths[i]) for i in range(3)), cell[3]]).rstrip() for cell in cells]
    unknown = [column.name for column in catalog.columns if row[column.name] is None]
    said = [f"Unknown: {', '.join(unknown)}."] if unknown else []
    said += [f"* {doubt}" for doubt in row.doubts] + [f"note: {note}" for note in row.notes]
    return "\n".join([f"{row.name} ({catalog.title})", "", *lines, "", *said])


def _table(catalog: Catalog, *, doubts: bool = True) -> str:
    header = ["name", *(_heading(catalog, column.name) for column in catalog.columns)]
    rows = [[_name(part), *(_cell(part, c.name) for c in catalog.columns)] for part in catalog.rows]
    widths = [max(len(row[i]) for row in [header, *rows]) for i in range(len(header))]
    table = [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in [header, *rows]
    ]
    said = [f"* {part.name}: {doubt}" for part in catalog.rows for doubt in part.doubts] if doubts else []
    weak = [g for part in catalog.rows for g in part.grades.values() if g in WEAK]
    legend = [f"~ {' or '.join(sorted(set(weak)))}"] if weak else []
    return "\n".join([catalog.title, "", *table, "", *said, *legend, f"Source: {catalog.source}"])


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
