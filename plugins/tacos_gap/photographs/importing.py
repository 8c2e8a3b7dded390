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
from tacos_gap.captures.targets.expectation import LEVEL_UNCERTAINTY
from tacos_gap.photographs.boards import USUAL_SQUARE_MM, BoardFound, boards_of, with_unseen_views
from tacos_gap.photographs.camera import CameraFound, camera_of, focal_px_of_views
from tacos_gap.photographs.caps_and_walls import with_kinds_weighed
from tacos_gap.photographs.exposure_times import with_times
from tacos_gap.photographs.folder_text import folder_text
from tacos_gap.photographs.given import Given, Guess
from tacos_gap.photographs.grouping import Stack, sharpest_of_views, stacks_of
from tacos_gap.photographs.looking import looked_at, of_one_form
from tacos_gap.photographs.picture import Picture
from tacos_gap.photographs.sidecars import sidecars_among
from tacos_gap.photographs.sources import passed_over, pictures_in, recordings_among
from tacos_gap.photographs.tables import Table, tables_among
from tacos_gap.report.words import first_of

_ORDER = ("dark", "flat", "bracket", "edge", "board", "chart", "sequence", "scene")


@dataclass(frozen=True, eq=False)
class Imported:
    """Result of an import.

    - `path`: the ``captures.yaml`` it wrote.
    - `entries`: the entries of its captures.
    - `camera`: the entry `camera`.
    - `guesses`: what it took for true although nothing says it.
    - `doubts`: what else it was unsure of, in sentences.
    """

    path: Path
    entries: tuple[dict[str, Any], ...]
    camera: CameraFound
    guesses: tuple[Guess, ...]
    doubts: tuple[str, ...]


def import_photographs(
    sources: Sequence[Path],
    out: Path,
    given: Given | None = None,
    notify: Callable[[str], None] | None = None,
    answered: Callable[[Sequence[Guess], Given], Given] | None = None,
) -> Imported:
    """Sort photographs, copy them into a new folder, and write its ``captures.yaml``.

    - `sources`: files and folders, searched through; RAW is taken where a JPEG of the same name lies beside
      it.
    - `out`: the folder, new or empty.
    - `given`: what the photographer says of camera, board and pictures.
    - `notify`: told which file is looked at.
    - `answered`: adds the photographer's answers to what was given; None leaves all guesses as they are.

    Raises UserError when there are no pictures, none can be read, or `out` is not empty or cannot be written.
    """
    given = given or Given()
    paths, others, doubts = pictures_in(sources)
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        what = "is not empty" if out.is_dir() else "is a file"
        raise UserError(Fault(str(out), what, "a folder that is new or empty", "Name another --out."))
    tables = [*tables_among(others, paths), *sidecars_among(others, paths)]
    doubts += recordings_among(sources)
    doubts += passed_over([path for path in others if path not in {table.path for table in tables}])
    pictures, unreadable = looked_at(paths, given, notify or (lambda text: None))
    pictures, of_other_forms = of_one_form(pictures)
    doubts += [*unreadable, *of_other_forms]
    found = _sorted(pictures, tables, given)
    if answered is not None and (more := answered(found.guesses, given)) != given:
        given, found = more, _sorted(pictures, tables, more)
    if not found.stacks:
        raise UserError(Fault(str(sources[0]), "no picture is left to import", "", " ".join(found.doubts)))
    path, doubts = out / FILE, [*doubts, *found.doubts]
    try:
        entries = tuple(_in_time_order(list(_entries(found, out, given))))
        path.write_text(folder_text(out.name, found.camera, entries, found.guesses, doubts), encoding="utf-8")
    except OSError as error:
        what = f"the captures cannot be written: {error.strerror or error}"
        expected = "a folder that may be written in, on a disk with room"
        raise UserError(Fault(str(out), what, expected, "Name another --out.")) from error
    return Imported(path, entries, found.camera, found.guesses, tuple(doubts))


@dataclass(frozen=True, eq=False)
class _Sorted:
    stacks: tuple[Stack, ...]
    boards: tuple[BoardFound, ...]
    camera: CameraFound
    guesses: tuple[Guess, ...]
    doubts: tuple[str, ...]

    def board_of(self, picture: Picture) -> BoardFound | None:
        return next((board for board in self.boards if picture in board.views), None)


def _sorted(looked_at: Sequence[Picture], tables: Sequence[Table], given: Given) -> _Sorted:
    pictures, doubts, guesses = with_times(looked_at, tables, given)
    pictures, of_kinds = with_kinds_weighed(pictures, given)
    with_boards = [picture for picture in pictures if picture.shown.kind == "board"]
    boards = boards_of(with_boards, given.inner_corners)
    pictures, boards = with_unseen_views(pictures, boards)
    lost = [picture for picture in with_boards if all(picture not in board.views for board in boards)]
    lost += _likelier_boards(pictures, with_boards, given)
    doubts += [f"{picture.name} is left out: {_not_seen(picture, boards, given)}." for picture in lost]
    kept = [picture for picture in pictures if picture not in lost]
    views = [view for board in boards for view in board.views.values()]
    camera = camera_of(kept or pictures, given, focal_px_of_views(views, pictures[0].size_px))
    stacks = tuple(sorted(stacks_of(kept), key=lambda stack: _ORDER.index(stack.kind)))
    all_guesses = (*of_kinds, *guesses, *_guesses(stacks, boards, given), *camera.guesses)
    return _Sorted(stacks, boards, camera, all_guesses, (*doubts, *camera.doubts, *_doubts(stacks)))


def _likelier_boards(
    pictures: Sequence[Picture], with_boards: Sequence[Picture], given: Given
) -> list[Picture]:
    """Pictures taken for more views of a board that pass for sharp edges: one that is not seen whole."""
    guessed = [p for p in pictures if p.shown.kind == "edge" and p.shown.doubt and p.name not in given.kinds]
    return guessed if len(with_boards) > 2 * len(guessed) else []


def _not_seen(picture: Picture, boards: Sequence[BoardFound], given: Given) -> str:
    counted = picture.shown.corners
    wanted = given.inner_corners or next((b.inner_corners for b in boards if b.layout is None), None)
    if picture.shown.markers is not None:
        return (
            f"it shows markers (DICT_{picture.shown.markers.family}), and not between the squares of a "
            f"ChArUco board that can be made out"
        )
    if wanted and counted and sorted(wanted) != sorted(counted):
        whose = "--board" if given.inner_corners else "as other pictures show"
        return (
            f"of its chessboard {counted[0]} x {counted[1]} inner corners are seen, not {wanted[0]} x "
            f"{wanted[1]} ({whose})"
        )
    return "its chessboard is not seen whole"


def _guesses(stacks: Sequence[Stack], boards: Sequence[BoardFound], given: Given) -> Iterator[Guess]:
    doubted: dict[tuple[str, str], list[str]] = {}
    for stack in stacks:
        for picture in stack.pictures:
            if picture.shown.doubt and picture.shown.kind == stack.kind and picture.name not in given.kinds:
                doubted.setdefault((picture.shown.doubt, stack.kind), []).append(picture.name)
    for (doubt, kind), names in doubted.items():
        yield Guess(f"{first_of(names)}: {doubt}", "kinds", kind, tuple(names))
    for stack in stacks:
        if stack.kind == "dark" and stack.first.facts.exposure_ms is None:
            names = [picture.name for picture in stack.pictures]
            yield Guess(
                f"The exposure time of the cap is left open ({first_of(names)}); dark current needs it. "
                f"Write exposure_ms, or put it into the names (dark_10ms.png).",
                "exposures_ms",
                "",
                tuple(names),
            )
    for best in dict.fromkeys((sharpest := sharpest_of_views(stacks)).values()):
        less = [p.name for stack, other in sharpest.items() if other is best for p in stack.pictures]
        yield Guess(
            f"{first_of(less)}: compared with {best.first.name}, the sharpest picture of that view, as if "
            f"all should look so; else let `simulated` give what is expected."
        )
    for board in boards:
        columns, rows = board.inner_corners
        if board.layout is not None:
            yield Guess(
                f"The board is taken for a ChArUco of {columns + 1} x {rows + 1} squares with markers of "
                f"{board.layout.marker_share:g} of a square ({board.layout.dictionary}), by where its "
                f"markers stand; correct `board` if rows are hidden in all pictures."
            )
        elif given.inner_corners is None:
            yield Guess(
                f"The chessboard is taken to have {columns} x {rows} inner corners, the fullest that several "
                f"pictures show; else part of it is hidden (--board {columns}x{rows}).",
                "inner_corners",
                f"{columns}x{rows}",
            )
    if boards and given.square_mm is None:
        yield Guess(
            f"The squares of the board are taken to be {USUAL_SQUARE_MM:g} mm (--square-mm). Distances "
            f"depend on it, the lens does not.",
            "square_mm",
            f"{USUAL_SQUARE_MM:g}",
        )


def _doubts(stacks: Sequence[Stack]) -> Iterator[str]:
    pictures = [picture for stack in stacks for picture in stack.pictures]
    untimed = [picture.name for picture in pictures if picture.facts.exposure_ms is None]
    if untimed:
        yield (
            f"{_untimed_words(untimed)}: dark current needs it, brackets are found by it. Write exposure_ms, "
            f"put it into the names (dark_10ms.png), or a table beside them (times.csv: file, exposure_ms)."
        )
    sharpest = sharpest_of_views(stacks)
    used = {*sharpest, *sharpest.values()}
    scenes = [
        p.name for stack in stacks if stack.kind == "scene" and stack not in used for p in stack.pictures
    ]
    if scenes:
        yield (
            f"Neither cap, wall, bracket, edge, board nor ColorChecker: {first_of(scenes)}. Such "
            f"pictures are not used until `simulated` gives their expected values."
        )


def _entries(found: _Sorted, out: Path, given: Given) -> Iterator[dict[str, Any]]:
    stacks = found.stacks
    isos = [p.facts.iso for stack in stacks for p in stack.pictures if p.facts.iso]
    lowest = min(isos, default=None)
    times = {id(stack): _seconds(stack.first.facts.taken) for stack in stacks}
    known = [time for time in times.values() if time is not None]
    files = {stack: _copied(stack, out, name) for stack, name in _named(stacks)}
    sharpest = sharpest_of_views(stacks)
    for stack, name in _named(stacks):
        facts = stack.first.facts
        entry: dict[str, Any] = {"id": name, "kind": stack.kind, "real": files[stack]}
        if facts.exposure_ms is not None:
            entry["exposure_ms"] = round(facts.exposure_ms, 6)
        if facts.gain_db is not None:
            entry["gain_db"] = facts.gain_db
        elif facts.iso and lowest and facts.iso != lowest:
            entry["gain_db"] = round(20 * math.log10(facts.iso / lowest), 2)
        if (taken := times[id(stack)]) is not None and len(known) == len(times):
            entry["taken_s"] = round(taken - min(known), 3)
        if stack.group:
            entry["group"] = stack.group
        if (board := found.board_of(stack.first)) is not None:
            entry["board"] = board.entry(given.square_mm or USUAL_SQUARE_MM)
        if (best := sharpest.get(stack)) is not None:
            own_light = {"simulated_frames": 1, "level_uncertainty": LEVEL_UNCERTAINTY}
            entry |= {"simulated": files[best][0], **own_light}
        yield entry


def _named(stacks: Sequence[Stack]) -> Iterator[tuple[Stack, str]]:
    """Captures with their names: their kinds, counted."""
    count: Counter[str] = Counter()
    for stack in stacks:
        count[stack.kind] += 1
        yield stack, f"{stack.kind}_{count[stack.kind]}"


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
