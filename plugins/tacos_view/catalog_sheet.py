"""Parts of a catalog drawn to one scale."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tacos_framework import Catalog, CatalogPart, Fault, OffTheShelf, UserError
from tacos_report.figures.canvas import NARROW_IN, draw
from tacos_report.palette import INK, MUTED, camera_colour

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_GAP_MM = 1.6


@dataclass(frozen=True)
class SheetFormat:
    """Size of parts and of their names in the drawing."""

    width_mm: float  # across the sheet, in millimetres of parts [mm]
    cell_mm: float  # least room across for a part, in millimetres of parts
    label_mm: float  # room below it for name and detail, likewise
    inches_per_mm: float  # size of the drawing over that of the parts [in/mm]
    name_pt: float  # size of letters
    detail_pt: float
    groups_in_a_row: int  # names of groups beside one another
    least_mm: float = 0.0  # the sheet is so wide, however few parts there are [mm]

    @property
    def letters_per_mm(self) -> float:
        """Letters of a name beside one another: each is about 0.7 of its height wide."""
        return self.inches_per_mm * 72 / (0.7 * self.name_pt)


ON_SCREEN = SheetFormat(
    width_mm=105.0,
    cell_mm=9.0,
    label_mm=3.4,
    inches_per_mm=0.1,
    name_pt=6.5,
    detail_pt=4.8,
    groups_in_a_row=5,
)


def for_phone(parts: Sequence[Outline]) -> SheetFormat:
    """A sheet as wide as a phone: three parts in a row at most, and no part wider than the sheet."""
    width_mm = max(43.0, max(part.width_mm for part in parts) + 2 * _GAP_MM)
    per_mm = NARROW_IN / width_mm
    return SheetFormat(
        width_mm=width_mm,
        cell_mm=width_mm / 3 - _GAP_MM,
        label_mm=0.42 / per_mm,
        inches_per_mm=per_mm,
        name_pt=8.0,
        detail_pt=6.5,
        groups_in_a_row=3,
        least_mm=width_mm,
    )


@dataclass(frozen=True)
class Outline:
    """A part as it is drawn: its active area, or the circle that a lens fills with light."""

    name: str
    detail: str  # second line of text below it
    width_mm: float
    height_mm: float
    round: bool = False  # a circle rather than a rectangle
    group: str = ""  # what its colour stands for


@dataclass(frozen=True)
class PlacedOutline:
    """An outline and its lower left corner on the sheet, y up [mm]."""

    outline: Outline
    x_mm: float
    y_mm: float


def outlines(catalog: Catalog) -> tuple[Outline, ...]:
    """The parts of a catalog that can be drawn, the smallest first.

    Raises UserError when the catalog knows no sizes.
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

    Raises UserError when no camera says so.
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


def arranged(parts: Sequence[Outline], form: SheetFormat = ON_SCREEN) -> tuple[PlacedOutline, ...]:
    placed: list[PlacedOutline] = []
    y = 0.0
    for row in _rows(parts, form):
        y -= max(part.height_mm for part in row) + form.label_mm
        x = 0.0
        for part in row:
            placed.append(PlacedOutline(part, x, y + form.label_mm))
            x += _cell_mm(part, form)
    return tuple(placed)


def _rows(parts: Sequence[Outline], form: SheetFormat) -> Iterator[list[Outline]]:
    row: list[Outline] = []
    for part in parts:
        if row and sum(_cell_mm(each, form) for each in [*row, part]) > form.width_mm:
            yield row
            row = []
        row.append(part)
    if row:
        yield row


def _cell_mm(part: Outline, form: SheetFormat) -> float:
    return max(part.width_mm, form.cell_mm) + _GAP_MM


def sheet(name: str, parts: Sequence[Outline], said: str, *, narrow: bool = False) -> str:
    """SVG of parts to one scale; ``narrow`` for the width of a phone, where names are larger.

    `name`: unique among the drawings of a page. `said`: in place of the picture to readers who do not see it.
    """
    form = for_phone(parts) if narrow else ON_SCREEN
    placed = arranged(parts, form)
    size_in = sheet_size_in(placed, form)
    name = f"{name}-narrow" if narrow else name
    return draw(name, size_in, said, lambda figure: paint_sheet(figure, placed, form))


def sheet_size_in(placed: Sequence[PlacedOutline], form: SheetFormat = ON_SCREEN) -> tuple[float, float]:
    """Width and height of the drawing, with the names of groups below the parts [in]."""
    wide, high = (mm * form.inches_per_mm for mm in _size_mm(placed, form))
    return wide, high + 0.3 * -(-len(_groups(placed)) // form.groups_in_a_row)


def _size_mm(placed: Sequence[PlacedOutline], form: SheetFormat) -> tuple[float, float]:
    """Width and height of what is to scale, with the scale itself below [mm of parts]."""
    wide = max(each.x_mm + _cell_mm(each.outline, form) for each in placed)
    return max(wide, form.least_mm), form.label_mm + 4 - min(each.y_mm for each in placed)


def _groups(placed: Sequence[PlacedOutline]) -> list[str]:
    return sorted({each.outline.group for each in placed})


def paint_sheet(figure: Figure, placed: Sequence[PlacedOutline], form: SheetFormat = ON_SCREEN) -> None:
    from matplotlib.patches import Patch

    if (layout := figure.get_layout_engine()) is not None:
        layout.set(w_pad=0, h_pad=0)  # type: ignore[call-arg]  # what is to scale fills the width
    axes = figure.add_subplot()
    wide, high = _size_mm(placed, form)
    axes.set_xlim(-0.8, wide - 0.8)
    axes.set_ylim(2 - high, 2)
    axes.set_aspect("equal")
    axes.axis("off")
    groups = _groups(placed)
    for each in placed:
        _paint_part(axes, each, camera_colour(1 + groups.index(each.outline.group)), form)
    bottom = 2 - high + 0.9
    axes.plot([0, 10], [bottom, bottom], color=INK, linewidth=1.4)
    axes.text(10.5, bottom, "10 mm", color=INK, va="center", fontsize=8)
    handles = [Patch(color=camera_colour(1 + i), alpha=0.35, label=group) for i, group in enumerate(groups)]
    figure.legend(handles=handles, loc="outside lower left", ncols=form.groups_in_a_row, labelcolor=INK)


def shortened(name: str, most: int) -> str:
    """A name of so many letters at most; the last word, which tells models apart, is cut last.

    >>> shortened("Hikrobot MVL-KF0814M-12MPE", 19), shortened("IMX219", 16)
    ('…MVL-KF0814M-12MPE', 'IMX219')
    """
    if len(name) <= most:
        return name
    kept = name.rpartition(" ")[2][-most + 1 :]
    before = name[: most - 1 - len(kept)]
    return f"{before}…{kept}" if len(before) > 2 else f"…{kept}"


def _paint_part(axes: Axes, placed: PlacedOutline, colour: str, form: SheetFormat) -> None:
    from matplotlib.patches import Ellipse, Patch, Rectangle

    part, x, y = placed.outline, placed.x_mm, placed.y_mm
    if part.round:
        shape: Patch = Ellipse((x + part.width_mm / 2, y + part.height_mm / 2), part.width_mm, part.height_mm)
    else:
        shape = Rectangle((x, y), part.width_mm, part.height_mm)
    shape.set(facecolor=colour, edgecolor=colour, alpha=0.35, linewidth=1.0)
    axes.add_patch(shape)
    name = shortened(part.name, int(_cell_mm(part, form) * form.letters_per_mm))
    axes.text(x, y - 0.09 * form.label_mm, name, color=INK, va="top", fontsize=form.name_pt)
    axes.text(x, y - 0.44 * form.label_mm, part.detail, color=MUTED, va="top", fontsize=form.detail_pt)
