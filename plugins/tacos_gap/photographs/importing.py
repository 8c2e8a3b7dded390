"""Photographs sorted into a folder of captures, with doubts said aloud."""

from __future__ import annotations

import math
import shutil
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from tacos_framework import Fault, UserError
from tacos_gap.captures.missing import FILE
from tacos_gap.photographs.boards import USUAL_SQUARE_MM, BoardFound, board_of
from tacos_gap.photographs.camera import CameraFound, Given, camera_of, focal_px_of_views
from tacos_gap.photographs.folder_text import folder_text
from tacos_gap.photographs.grouping import Stack, stacks_of
from tacos_gap.photographs.looking import looked_at, of_one_form
from tacos_gap.photographs.picture import Picture
from tacos_gap.photographs.sources import pictures_in
from tacos_gap.report.words import first_of

_UNKNOWN_MS = 30.0
_ORDER = ("dark", "flat", "bracket", "edge", "board", "chart", "sequence", "scene")


@dataclass(frozen=True, eq=False)
class Imported:
    """What an import made.

    Parameters
    ----------
    path
        The ``captures.yaml`` it wrote.
    entries
        The entries of its captures.
    camera
        The entry `camera`.
    doubts
        What it was unsure of, in sentences.
    """

    path: Path
    entries: tuple[dict[str, Any], ...]
    camera: CameraFound
    doubts: tuple[str, ...]


def import_photographs(
    sources: Sequence[Path],
    out: Path,
    given: Given | None = None,
    notify: Callable[[str], None] | None = None,
) -> Imported:
    """Sort photographs, copy them into a new folder, and write its ``captures.yaml``.

    Parameters
    ----------
    sources
        Files and folders, searched through; RAW is taken where a JPEG of the same name lies beside it.
    out
        The folder, new or empty.
    given
        What the photographer says of camera and board.
    notify
        Told which file is looked at.

    Raises
    ------
    UserError
        When there are no pictures, none can be read, or `out` is not empty or cannot be written.
    """
    given = given or Given()
    paths, doubts = pictures_in(sources)
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        what = "is not empty" if out.is_dir() else "is a file"
        raise UserError(Fault(str(out), what, "a folder that is new or empty", "Name another --out."))
    pictures, unreadable = looked_at(paths, given, notify or (lambda text: None))
    pictures, of_other_forms = of_one_form(pictures)
    doubts += [*unreadable, *of_other_forms]
    boards = [picture for picture in pictures if picture.shown.kind == "board"]
    board = board_of(boards, given.inner_corners)
    lost = [picture for picture in boards if board is None or picture not in board.corners_px]
    doubts += [f"{picture.name} is left out: {_not_seen(picture, board, given)}." for picture in lost]
    pictures = [picture for picture in pictures if picture not in lost]
    if not pictures:
        raise UserError(Fault(str(sources[0]), "no picture is left to import", "", " ".join(doubts)))
    seen = tuple(board.corners_px.values()) if board else ()
    focal_px = focal_px_of_views(seen, board.inner_corners, pictures[0].size_px) if board else None
    camera = camera_of(pictures, given, focal_px)
    stacks = sorted(stacks_of(pictures), key=lambda stack: _ORDER.index(stack.kind))
    doubts += [*camera.doubts, *_doubts(stacks, board, given)]
    path = out / FILE
    try:
        entries = tuple(_in_time_order(list(_entries(stacks, out, board, given))))
        path.write_text(folder_text(out.name, camera, entries, doubts), encoding="utf-8")
    except OSError as error:
        what = f"the captures cannot be written: {error.strerror or error}"
        expected = "a folder that may be written in, on a disk with room"
        raise UserError(Fault(str(out), what, expected, "Name another --out.")) from error
    return Imported(path, entries, camera, tuple(doubts))


def _not_seen(picture: Picture, board: BoardFound | None, given: Given) -> str:
    """Why a chessboard is of no use."""
    counted = picture.shown.corners
    wanted = given.inner_corners or (board.inner_corners if board else None)
    if wanted and counted and sorted(wanted) != sorted(counted):
        whose = "--board" if given.inner_corners else "most pictures"
        return (
            f"of its chessboard {counted[0]} x {counted[1]} inner corners are seen, not {wanted[0]} x "
            f"{wanted[1]} ({whose})"
        )
    return "its chessboard is not seen whole"


def _doubts(stacks: Sequence[Stack], board: BoardFound | None, given: Given) -> Iterator[str]:
    doubted: dict[str, list[str]] = {}
    for stack in stacks:
        for picture in stack.pictures:
            if picture.shown.doubt and picture.shown.kind == stack.kind:
                doubted.setdefault(picture.shown.doubt, []).append(picture.name)
    yield from (f"{first_of(names)}: {doubt}" for doubt, names in doubted.items())
    pictures = [picture for stack in stacks for picture in stack.pictures]
    untimed = [picture.name for picture in pictures if picture.facts.exposure_ms is None]
    if untimed:
        yield (
            f"{_untimed_words(untimed)}: darks need it, brackets are found by it. Write exposure_ms, or put "
            f"it into the names (dark_10ms.png)."
        )
    if board is not None and given.inner_corners is None:
        columns, rows = board.inner_corners
        yield f"The chessboard seems to have {columns} x {rows} inner corners (--board {columns}x{rows})."
    if board is not None and given.square_mm is None:
        yield (
            f"The squares of the chessboard are taken to be {USUAL_SQUARE_MM:g} mm (--square-mm); distances "
            f"hang on it, the lens does not."
        )
    scenes = [picture.name for stack in stacks if stack.kind == "scene" for picture in stack.pictures]
    if scenes:
        yield (
            f"Neither cap, wall, bracket, edge, chessboard nor ColorChecker: {first_of(scenes)}. Nothing is "
            f"known of what is to be seen there, which is left unused until `simulated` says it."
        )


def _entries(
    stacks: Sequence[Stack], out: Path, board: BoardFound | None, given: Given
) -> Iterator[dict[str, Any]]:
    """Entries of captures, their files copied."""
    isos = [p.facts.iso for stack in stacks for p in stack.pictures if p.facts.iso]
    lowest = min(isos, default=None)
    times = {id(stack): _seconds(stack.first.facts.taken) for stack in stacks}
    known = [time for time in times.values() if time is not None]
    count: Counter[str] = Counter()
    for stack in stacks:
        count[stack.kind] += 1
        name = f"{stack.kind}_{count[stack.kind]}"
        facts = stack.first.facts
        entry: dict[str, Any] = {"id": name, "kind": stack.kind, "real": _copied(stack, out, name)}
        if facts.exposure_ms is not None or stack.kind in ("dark", "bracket"):
            entry["exposure_ms"] = round(facts.exposure_ms or _UNKNOWN_MS, 6)
        if facts.iso and lowest and facts.iso != lowest:
            entry["gain_db"] = round(20 * math.log10(facts.iso / lowest), 2)
        if (taken := times[id(stack)]) is not None and len(known) == len(times):
            entry["taken_s"] = round(taken - min(known), 3)
        if stack.group:
            entry["group"] = stack.group
        if stack.kind == "board" and board is not None:
            square_mm = given.square_mm or USUAL_SQUARE_MM
            entry["board"] = {"inner_corners": list(board.inner_corners), "square_mm": square_mm}
        yield entry


def _seconds(taken: str) -> float | None:
    """Seconds since some moment of a date and time as EXIF writes them; None of what is none.

    >>> _seconds("2026:05:01 10:00:07.25") - _seconds("2026:05:01 10:00:00.")
    7.25
    """
    written, _, fraction = taken.partition(".")
    try:
        moment = datetime.strptime(written, "%Y:%m:%d %H:%M:%S").replace(tzinfo=UTC)
    except ValueError:
        return None
    return moment.timestamp() + (float(f"0.{fraction}") if fraction.isdecimal() else 0.0)


def _in_time_order(entries: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The entries in the order they were taken, where the pictures say when; else as they are."""
    return sorted(entries, key=lambda entry: float(entry.get("taken_s", 0.0)))


def _copied(stack: Stack, out: Path, name: str) -> list[str]:
    (out / name).mkdir(parents=True, exist_ok=True)
    files = []
    for number, picture in enumerate(stack.pictures):
        own = f"{name}/{picture.name}"
        if (out / own).exists():  # of another folder of photographs
            own = f"{name}/{number}_{picture.name}"
        shutil.copy2(picture.path, out / own)
        files.append(own)
    return files


def _untimed_words(names: Sequence[str]) -> str:
    if len(names) == 1:
        return f"One picture does not say how long it was exposed ({names[0]})"
    return f"{len(names)} pictures do not say how long they were exposed ({names[0]}, ...)"
