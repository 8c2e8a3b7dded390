"""Parts of a catalog drawn to one scale."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tacos_framework.catalog import Catalog, CatalogPart, OffTheShelf
from tacos_framework.errors import Fault, UserError
from tacos_report.palette import INK, MUTED, camera_colour

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LABEL_MM, _CELL_MM, _SHEET_MM = 3.4, 9.0, 105.0
"""Room below a part for its name, least room across, and across the sheet, in millimetres of parts [mm]."""

_LETTERS_PER_MM = 1.6  # of the drawing's text
INCHES_PER_MM = 0.1
"""Size of the drawing over that of the parts."""


@dataclass(frozen=True)
class Outline:
    """A part as it is drawn: its active area, or the circle that a lens fills with light.

    Parameters
    ----------
    name, detail
        Two lines of text below it.
    width_mm, height_mm
        Size [mm].
    round
        A circle rather than a rectangle.
    group
        What its colour stands for.
    """

    name: str
    detail: str
    width_mm: float
    height_mm: float
    round: bool = False
    group: str = ""


@dataclass(frozen=True)
class PlacedOutline:
    """An outline and its lower left corner on the sheet, y up [mm]."""

    outline: Outline
    x_mm: float
    y_mm: float


def outlines(catalog: Catalog) -> tuple[Outline, ...]:
    """The parts of a catalog that can be drawn, the smallest first.

    Raises
    ------
    UserError
        When the catalog knows no sizes.
    """
    found = [outline for part in catalog.rows if (outline := _outline(part)) is not None]
    if not found:
        expected = "columns width_px, height_px and pixel_um, or image_circle_mm"
        raise UserError(Fault(catalog.name, "its parts have no sizes to draw", expected))
    return tuple(sorted(found, key=lambda each: (each.width_mm * each.height_mm, each.name)))


def _outline(part: CatalogPart) -> Outline | None:
    values = part.values
    if all(isinstance(values.get(name), int | float) for name in ("width_px", "height_px", "pixel_um")):
        wide, high, pitch = (part.number(name) for name in ("width_px", "height_px", "pixel_um"))
        detail = f"{wide:.0f} x {high:.0f}, {pitch:g} um"
        group = str(values.get("shutter") or "shutter not stated")
        return Outline(part.name, detail, wide * pitch * 1e-3, high * pitch * 1e-3, group=group)
    if isinstance(values.get("image_circle_mm"), int | float):
        circle = part.number("image_circle_mm")
        focal = values.get("focal_length_mm")
        detail = f"{focal:g} mm, circle {circle:g} mm" if isinstance(focal, int | float) else f"{circle:g} mm"
        return Outline(
            part.name, detail, circle, circle, True, str(values.get("mount") or "mount not stated")
        )
    return None


def camera_outlines(cameras: Sequence[OffTheShelf]) -> tuple[Outline, ...]:
    """The sensors of cameras that say which one they have, the smallest first; each rig has a colour.

    Raises
    ------
    UserError
        When no camera says so.
    """
    found = []
    for camera in cameras:
        sensor = camera.fixes.get("sensor")
        sizes = sensor if isinstance(sensor, Mapping) else {}
        part = CatalogPart(camera.title, {**sizes, "shutter": camera.rig})
        if (outline := _outline(part)) is not None:
            found.append(outline)
    if not found:
        what = "none of its cameras says the size of its sensor"
        expected = "fixes: {sensor: {width_px: ..., height_px: ..., pixel_um: ...}}"
        raise UserError(Fault("the catalog of cameras", what, expected))
    return tuple(sorted(found, key=lambda each: (each.width_mm * each.height_mm, each.name)))


def arranged(parts: Sequence[Outline]) -> tuple[PlacedOutline, ...]:
    """Parts in rows from the top left, none over another."""
    placed: list[PlacedOutline] = []
    y = 0.0
    for row in _rows(parts):
        y -= max(part.height_mm for part in row) + _LABEL_MM
        x = 0.0
        for part in row:
            placed.append(PlacedOutline(part, x, y + _LABEL_MM))
            x += _cell_mm(part)
    return tuple(placed)


def _rows(parts: Sequence[Outline]) -> Iterator[list[Outline]]:
    row: list[Outline] = []
    for part in parts:
        if row and sum(map(_cell_mm, row)) + _cell_mm(part) > _SHEET_MM:
            yield row
            row = []
        row.append(part)
    if row:
        yield row


def _cell_mm(part: Outline) -> float:
    return max(part.width_mm, _CELL_MM) + 1.6


def size_in(placed: Sequence[PlacedOutline]) -> tuple[float, float]:
    """Width and height of the drawing [in]."""
    wide = max(each.x_mm + _cell_mm(each.outline) for each in placed)
    high = -min(each.y_mm for each in placed) + _LABEL_MM + 4
    return wide * INCHES_PER_MM, high * INCHES_PER_MM


def paint_sheet(figure: Figure, placed: Sequence[PlacedOutline]) -> None:
    """Draw the parts, and a scale, on a figure of `size_in`."""
    axes = figure.add_subplot()
    wide, high = (inches / INCHES_PER_MM for inches in size_in(placed))
    axes.set_xlim(-0.8, wide - 0.8)
    axes.set_ylim(2 - high, 2)
    axes.set_aspect("equal")
    axes.axis("off")
    groups = sorted({each.outline.group for each in placed})
    for each in placed:
        _paint_part(axes, each, camera_colour(1 + groups.index(each.outline.group)))
    bottom = 2 - high + 0.9
    axes.plot([0, 10], [bottom, bottom], color=INK, linewidth=1.4)
    axes.text(10.5, bottom, "10 mm", color=INK, va="center", fontsize=8)
    for i, group in enumerate(groups):
        axes.text(20 + 16 * i, bottom, group, color=camera_colour(1 + i), va="center", fontsize=8)


def shortened(name: str, cell_mm: float) -> str:
    """A name as far as there is room; what is left out stands before its last word, which tells models apart.

    Examples
    --------
    >>> shortened("Hikrobot MVL-KF0814M-12MPE", 12.0), shortened("IMX219", 10.0)
    ('…MVL-KF0814M-12MPE', 'IMX219')
    """
    most = int(cell_mm * _LETTERS_PER_MM)
    if len(name) <= most:
        return name
    kept = name.rpartition(" ")[2][-most + 1 :]
    before = name[: most - 1 - len(kept)]
    return f"{before}…{kept}" if len(before) > 2 else f"…{kept}"


def _paint_part(axes: Axes, placed: PlacedOutline, colour: str) -> None:
    from matplotlib.patches import Ellipse, Patch, Rectangle

    part, x, y = placed.outline, placed.x_mm, placed.y_mm
    if part.round:
        shape: Patch = Ellipse((x + part.width_mm / 2, y + part.height_mm / 2), part.width_mm, part.height_mm)
    else:
        shape = Rectangle((x, y), part.width_mm, part.height_mm)
    shape.set(facecolor=colour, edgecolor=colour, alpha=0.35, linewidth=1.0)
    axes.add_patch(shape)
    axes.text(x, y - 0.3, shortened(part.name, _cell_mm(part)), color=INK, va="top", fontsize=6.5)
    axes.text(x, y - 1.5, part.detail, color=MUTED, va="top", fontsize=4.8)
