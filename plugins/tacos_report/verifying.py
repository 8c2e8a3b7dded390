"""Which files of a run are whole, which are damaged, and what that means; for ``tacos verify``."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from tacos_framework import Fault, UserError
from tacos_framework.results.checksums import (
    Damaged,
    Lines,
    checked_json,
    checked_lines,
    checked_text,
    checksum,
)
from tacos_framework.results.reading import MANIFEST, file_of_run
from tacos_framework.results.results import CHECKPOINT, RECIPE
from tacos_framework.study.journal import JOURNAL
from tacos_framework.study.run_files import JournalLine, KeptCheckpoint, mistyped

MEANINGS: Mapping[str, str] = {
    RECIPE: "The run cannot go on; what came out stands.",
    MANIFEST: "Nothing tells whether code and files are still those it was begun with, so it cannot go on.",
    CHECKPOINT: "The run cannot go on; what came out stands.",
    JOURNAL: "The run cannot go on; without this file, it goes on from the checkpoint.",
    "generations.jsonl": "The run cannot go on, and a report would lack generations.",
    "products.jsonl": "The run cannot go on.",
    "result.json": "Do not rely on it; --resume writes it anew from the checkpoint.",
    "weights": "What the tasks have learnt is lost, so the run cannot go on.",
    "samples": "The picture may show anything; --resume takes it anew.",
}
"""What damage of a file means for its run."""


@dataclass(frozen=True)
class FileCheck:
    """What became of one file.

    Parameters
    ----------
    name
        The file, below the folder of the run.
    damage
        What is wrong with it, in a few words; None where it is whole.
    note
        What else is to say.
    """

    name: str
    damage: str | None = None
    note: str = ""

    @property
    def meaning(self) -> str:
        """What its damage means."""
        return MEANINGS.get(self.name, MEANINGS.get(self.name.partition("/")[0], ""))


def verify(folder: Path) -> list[FileCheck]:
    """Check every file of a run that carries a checksum.

    Raises
    ------
    UserError
        When the folder holds no run with checksums.
    """
    if not folder.is_dir() or not any((folder / name).exists() for name in (MANIFEST, CHECKPOINT)):
        raise UserError(
            Fault(
                str(folder),
                "there is no manifest.json here",
                "the results folder of a study",
                "Name the folder that tacos-run wrote with --out; earlier versions wrote no checksums.",
            )
        )
    return list(_checks(folder))


def _checks(folder: Path) -> Iterator[FileCheck]:
    found: dict[str, Any] = {}
    whole: dict[str, Callable[[bytes], Any]] = {
        RECIPE: checked_text,
        MANIFEST: checked_json,
        CHECKPOINT: _checkpoint,
        "result.json": checked_json,
    }
    for name, parse in whole.items():
        check, found[name] = _check(folder, name, parse)
        if check.damage is None or (folder / name).exists() or name in (RECIPE, MANIFEST):
            yield check
    checkpoint = found[CHECKPOINT] or {}
    ends = checkpoint.get("lines", {})
    lines = {path.name for path in folder.glob("*.jsonl")} | set(ends)
    for name in sorted(lines):
        check, found[name] = _check(folder, name, partial(_reaching, name=name, end=ends.get(name)))
        torn = found[name] is not None and found[name].torn
        yield FileCheck(name, check.damage, "its last line was cut short" if torn else "")
    journal = found.get(JOURNAL) or Lines()
    of_weights = [*checkpoint.get("weights", {}).values()]
    of_weights += [file for line in journal.values for file in line["weights"].values()]
    recorded = {f"weights/{name}.safetensors": wanted for name, wanted in of_weights}
    for name, wanted in sorted({**recorded, **checkpoint.get("samples", {})}.items()):
        yield _check(folder, name, partial(_as_recorded, wanted=wanted))[0]
    for name in ("report.html", "log.txt"):
        if (folder / name).exists():
            yield FileCheck(name, note="has no checksum; nothing reads it")


def _check(folder: Path, name: str, parse: Callable[[bytes], Any]) -> tuple[FileCheck, Any]:
    try:
        if not (folder / name).resolve().is_relative_to(folder.resolve()):
            raise Damaged("it is named there and leads out of the folder")
        return FileCheck(name), parse(file_of_run(folder / name))
    except Damaged as error:
        return FileCheck(name, str(error)), None


def _checkpoint(data: bytes) -> dict[str, Any]:
    checkpoint = checked_json(data)
    _check_type(KeptCheckpoint, [checkpoint])
    return checkpoint


def _check_type(kind: type[BaseModel], values: Iterable[Mapping[str, Any]]) -> None:
    """A checksum that fits is no proof that a run wrote a file."""
    if what := mistyped(kind, values):
        raise Damaged(what)


def _reaching(data: bytes, name: str, end: Mapping[str, Any] | None) -> Lines:
    lines = checked_lines(data)
    if name == JOURNAL:
        _check_type(JournalLine, lines.values)
    if end is not None:
        lines.check_reaches(end)
    return lines


def _as_recorded(data: bytes, wanted: str) -> None:
    if checksum(data) != wanted:
        raise Damaged("its checksum is not the one that the run wrote down")
