"""A page that shows what each picture of a folder of captures is taken for, to be looked through."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tacos_files.camera_images import read_image
from tacos_framework import UserError
from tacos_framework.files import read_lines
from tacos_gap.captures.entries import CaptureCamera, CaptureEntry
from tacos_gap.captures.files import CaptureFiles
from tacos_gap.captures.reader import read_entries
from tacos_gap.report.photographed import TELLS, small_picture
from tacos_gap.report.words import captures_in_words
from tacos_report.page import Block, Code, ContactSheet, Page, PagePicture, Paragraph, Section, image_uri
from tacos_report.quantities import number

FRAMES = 4
"""Pictures that are shown of a capture; the others differ from them by their noise."""


def contact_sheet(folder: Path) -> Page:
    """The pictures of a folder under the kinds they are taken for, with what the import said of them.

    Raises UserError with all faults of ``captures.yaml``, and all files that are missing or no pictures.
    """
    path, document, entry = read_entries(folder)
    files = CaptureFiles(path.parent, document, entry.camera.channels)
    found = [files.found(i, "real", capture.real) for i, capture in enumerate(entry.captures)]
    if files.faults:
        raise UserError(files.faults)
    by_kind: dict[str, list[tuple[CaptureEntry, Sequence[Path]]]] = {}
    for capture, paths in zip(entry.captures, found, strict=True):
        by_kind.setdefault(capture.kind, []).append((capture, paths))
    counts = ", ".join(f"{len(members)} {kind}" for kind, members in by_kind.items())
    sections = [
        Section(_title(kind, members), tuple(_sheet(members, entry.camera)))
        for kind, members in by_kind.items()
    ]
    if said := list(_comments(path)):
        sections.append(Section("Said by the import", tuple(Paragraph(text) for text in said)))
    correct = f"Correct {path}, then:"
    check = f"tacos captures check {shlex.quote(str(path.parent))}"
    sections.append(Section("If a picture has the wrong kind", (Paragraph(correct), Code(check))))
    return Page(
        "contact sheet",
        f"{captures_in_words(len(entry.captures))}: {counts}",
        "Each picture stands under the kind it is taken for. A wrong kind makes a wrong diagnosis, and is "
        "seen here at a glance.",
        sections,
    )


def _title(kind: str, members: Sequence[tuple[CaptureEntry, Sequence[Path]]]) -> str:
    pictures = sum(len(paths) for _, paths in members)
    return f"{kind}: {pictures} {'picture' if pictures == 1 else 'pictures'}"


def _sheet(members: Sequence[tuple[CaptureEntry, Sequence[Path]]], camera: CaptureCamera) -> Iterator[Block]:
    kind = members[0][0].kind
    yield Paragraph(f"Tells {TELLS[kind]}.")
    yield ContactSheet(
        tuple(
            PagePicture(image_uri(_thumbnail(path, camera)), _caption(capture, path, len(paths)))
            for capture, paths in members
            for path in paths[:FRAMES]
        )
    )


def _thumbnail(path: Path, camera: CaptureCamera) -> NDArray[np.uint8]:
    return small_picture(read_image(path, str(path)), camera.black_level_dn, camera.white)


def _caption(capture: CaptureEntry, path: Path, pictures: int) -> str:
    said = [f"{path.name}: {capture.id}"]
    if pictures > FRAMES:
        said.append(f"one of {pictures}")
    said.append(f"{number(capture.exposure_ms, 4)} ms" if capture.exposure_ms else "exposure not stated")
    if capture.gain_db:
        said.append(f"{capture.gain_db:g} dB")
    if capture.group:
        said.append(capture.group)
    if capture.board:
        columns, rows = capture.board.inner_corners
        said.append(f"{capture.board.pattern} of {columns} x {rows}, {capture.board.square_mm:g} mm")
    return ", ".join(said)


def _comments(path: Path) -> Iterator[str]:
    text = ""
    for line in read_lines(path):
        if not line.startswith("#"):
            break
        words = line.removeprefix("#").strip()
        if words.startswith("- ") or not words or words.endswith(":"):
            if text:
                yield text
            text = words.removeprefix("- ") if words.startswith("- ") else ""
        elif text:
            text += f" {words}"
    if text:
        yield text
