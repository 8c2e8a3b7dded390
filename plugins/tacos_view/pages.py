"""Output of ``tacos view``: PNG files, and a page of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from tacos_files.images import decode_samples
from tacos_framework import Catalog, OffTheShelf
from tacos_framework.files import made_folder
from tacos_report.page import (
    Legend,
    Page,
    PagePicture,
    Paragraph,
    Section,
    SideBySide,
    Table,
    in_both_widths,
    write_page,
)
from tacos_report.page import Warnings as PageWarnings
from tacos_view.catalog_sheet import (
    Outline,
    arranged,
    camera_outlines,
    outlines,
    paint_sheet,
    sheet,
    sheet_size_in,
)
from tacos_view.effect_ladder import EffectLadder
from tacos_view.floor_plan import floor_plan
from tacos_view.pictures import (
    Picture,
    class_colours,
    encoded_png,
    png_uri,
    reduced,
    shown_depth,
    shown_frame,
    shown_objects,
)
from tacos_view.rendering import Rendering

_ON_PAGE_PX = 640
CAMERA_FACTS = ("pixels", "pitch of a pixel", "focal length", "field of view")


class ViewFolder:
    """A folder of pictures; each is written as it is added, and the page last.

    `out`: the folder; made where it is not there. Files of the same names are replaced.
    """

    def __init__(self, out: Path) -> None:
        self.out = made_folder(out)

    def add(self, name: str, picture: Picture, caption: str) -> PagePicture:
        (self.out / f"{name}.png").write_bytes(encoded_png(picture))
        return PagePicture(png_uri(reduced(picture, _ON_PAGE_PX)), caption)

    def close(self, page: Page) -> Path:
        path = self.out / "index.html"
        write_page(path, page)
        return path


def write_rendering(out: Path, rendering: Rendering, what: str, assumed: Sequence[str] = ()) -> Path:
    """The plan of a world and what a camera sees in it.

    `what`: the recipe or scene, as the user named it. `assumed`: design variables that nobody gave a value.
    """
    folder = ViewFolder(out)
    first = rendering.first
    above = floor_plan(rendering.world, rendering.trajectory, first.world_from_camera, first.camera)
    plan = folder.add("plan", above, "From above. Orange: the way; blue: where the frames were taken from.")
    rows: list[SideBySide] = []
    for i in range(len(rendering)):
        for name, taken in rendering.cameras.items():
            levels = rendering.black_level_dn, rendering.white_level_dn
            frame = shown_frame(taken.image[i], *levels, coded=rendering.coded)
            stem = f"frame_{i + 1}" if len(rendering.cameras) == 1 else f"frame_{i + 1}_{name}"
            pictures = (
                folder.add(stem, frame, f"{i + 1}, {name}, at {rendering.time_s[i]:.1f} s"),
                folder.add(f"{stem}_depth", shown_depth(taken.depth_m[i]), "Depth; near is bright."),
                folder.add(
                    f"{stem}_objects",
                    shown_objects(taken.object_id[i], rendering.world.class_of_object),
                    "Objects, in shades of the colours of their classes.",
                ),
            )
            rows.append(SideBySide(pictures))
    notes = (
        [
            PageWarnings(
                "Assumed", tuple(f"{name} is not set; using the middle of its range" for name in assumed)
            )
        ]
        if assumed
        else []
    )
    world = rendering.world
    if world.remarks:
        notes.append(PageWarnings("The file", world.remarks))
    if doubts := rendering.doubts:
        notes.append(PageWarnings("Exposure", doubts))
    if len(world.objects) == 1:
        what_to_do = "nothing in this world is labelled, so tasks about things find none"
        notes.append(PageWarnings("Labels", (what_to_do,)))
    labelled = len({thing.class_name for thing in world.objects[1:]})
    page = Page(
        eyebrow="tacos view",
        title=f"{what}, seen by {rendering.title}",
        lead=(
            f"{world.triangle_count} triangles, {len(world.objects) - 1} labelled objects of {labelled} "
            f"classes, {len(world.lights)} lights."
        ),
        sections=(
            Section("What the camera sees", (_camera_table(rendering), *notes, *_legend(rendering), *rows)),
            Section("Where", (plan,)),
        ),
    )
    return folder.close(page)


def _camera_table(rendering: Rendering) -> Table:
    rows = []
    for name, taken in rendering.cameras.items():
        camera = taken.camera
        rows.append(
            (
                name,
                f"{camera.width_px} x {camera.height_px}",
                f"{camera.pixel_um * camera.binning:g} um",
                f"{camera.focal_length_mm:.3g} mm",
                f"{camera.hfov_deg:.1f} x {camera.vfov_deg:.1f} deg",
                f"{rendering.exposed(name).saturated:.1%}",
                f"{rendering.exposed(name).dark:.1%}",
            )
        )
    return Table(("camera", *CAMERA_FACTS, "saturated", "nearly black"), tuple(rows))


def _legend(rendering: Rendering) -> Iterator[Legend]:
    seen = np.unique(np.concatenate([np.unique(each.object_id) for each in rendering.cameras.values()]))
    classes = np.unique(rendering.world.class_of_object[seen])
    names, colours = rendering.world.class_names, class_colours(len(rendering.world.class_names))
    yield Legend(tuple((names[i], "rgb({}, {}, {})".format(*colours[i])) for i in classes))


def write_ladder(out: Path, ladder: EffectLadder, what: str) -> Path:
    folder = ViewFolder(out)
    frames, changes = [], []
    for i, step in enumerate(ladder.steps):
        frames.append(folder.add(f"step_{i}", step.frame, step.label))
        changes.append(folder.add(f"step_{i}_difference", step.difference, step.label))
    said = f"Frame less the frame without the effect, times {ladder.amplification:.3g}; grey is no change."
    page = Page(
        eyebrow="tacos view",
        title=f"{ladder.use}, from off to severe",
        lead=f"The same frame of {what} with the same noise throughout.",
        sections=(
            Section("What the camera delivers", _two_a_row(frames)),
            Section("What the effect changes", (Paragraph(said), *_two_a_row(changes))),
        ),
    )
    return folder.close(page)


def _two_a_row(pictures: Sequence[PagePicture]) -> tuple[SideBySide, ...]:
    return tuple(SideBySide(tuple(pictures[i : i + 2])) for i in range(0, len(pictures), 2))


def write_catalog(out: Path, catalog: Catalog) -> Path:
    parts = outlines(catalog)
    said = "the circle each lens fills with light." if parts[0].round else "the active area of each sensor."
    names = [part.name for part in catalog.rows]
    return _write_sheet(out, catalog.name, (catalog.title, catalog.source), parts, said, names)


def write_cameras(out: Path, name: str, cameras: Sequence[OffTheShelf]) -> Path:
    said = "the active area of each camera's sensor."
    titles = [camera.title for camera in cameras]
    rows = tuple(
        (camera.title, camera.maker, camera.rig, ", ".join(map(_fixed, camera.fixes.items())))
        for camera in cameras
    )
    table = Section("What each fixes", (Table(("camera", "maker", "rig", "fixes"), rows),))
    head = ("Cameras off the shelf", f"{len(cameras)} cameras of the catalog {name}")
    return _write_sheet(out, name, head, camera_outlines(cameras), said, titles, table)


def _fixed(item: tuple[str, Any]) -> str:
    name, value = item
    return f"{name} {value.get('name', 'custom') if isinstance(value, Mapping) else value}"


def _write_sheet(
    out: Path,
    name: str,
    head: tuple[str, str],
    parts: Sequence[Outline],
    said: str,
    names: Sequence[str],
    *more: Section,
) -> Path:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    placed = arranged(parts)
    folder = ViewFolder(out)
    figure = Figure(figsize=sheet_size_in(placed), facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)
    paint_sheet(figure, placed)
    png = BytesIO()
    figure.savefig(png, format="png", dpi=110)
    folder.add(name, decode_samples(png.getvalue(), name, "the drawing"), "")
    drawn = {part.name for part in parts}
    left_out = [each for each in names if each not in drawn]
    said = f"{len(parts)} parts to one scale: {said}"
    drawing = in_both_widths(partial(sheet, name, parts, said), said)
    notes = [Paragraph(f"Without a stated size: {', '.join(left_out)}.")] if left_out else []
    page = Page("tacos view", *head, (Section("To scale", (drawing, *notes)), *more))
    return folder.close(page)
