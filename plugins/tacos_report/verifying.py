"""Whole and damaged files of a run, and the consequences; for ``tacos verify``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from tacos_framework import Fault, UserError
from tacos_framework.store import (
    CHECKPOINT,
    DATABASE,
    FILES,
    MANIFEST,
    RECIPE,
    DamagedError,
    Database,
    digest,
    file_of_run,
    lines_file,
)
from tacos_framework.study import EVALUATIONS, KeptCheckpoint, KeptJob, checked_type

MEANINGS: Mapping[str, str] = {
    DATABASE: "The run cannot go on, and its other files cannot be verified.",
    RECIPE: "The run cannot go on; what came out stands.",
    MANIFEST: "Code and files cannot be compared with those at its start, so it cannot go on.",
    "result.json": "Do not rely on it; --resume writes it anew.",
    "weights": "What the tasks have learnt is lost, so the run cannot go on.",
    "samples": "The picture may show anything; --resume takes it anew.",
}
"""What damage of a file means for its run."""

OF_LINES = "Do not rely on it; reports read the database, and --resume writes it anew."
"""What damage of a file of JSON lines means."""


@dataclass(frozen=True)
class FileCheck:
    """State of one file. `damage`: what is wrong with it, in a few words; None where it is whole."""

    name: str
    damage: str | None = None
    note: str = ""

    @property
    def meaning(self) -> str:
        if self.name.endswith(".jsonl"):
            return OF_LINES
        return MEANINGS.get(self.name, MEANINGS.get(self.name.partition("/")[0], ""))


def verify(folder: Path) -> list[FileCheck]:
    """Check the database of a run, and every file against what stands there.

    Raises UserError when the folder holds no run with a database.
    """
    if not (folder / DATABASE).exists():
        raise UserError(
            Fault(
                str(folder),
                f"there is no {DATABASE} here",
                "the results folder of a run",
                "Name the folder that tacos-run wrote with --out; earlier versions wrote no database.",
            )
        )
    try:
        with Database(folder / DATABASE, read_only=True) as database:
            _check_database(database)
            return [FileCheck(DATABASE), *_checks(folder, database)]
    except UserError as error:
        return [FileCheck(DATABASE, error.faults[0].what)]


def _check_database(database: Database) -> None:
    """A digest that fits is no proof that a run wrote an entry, so types are checked too."""
    database.check()
    for kind, model in ((CHECKPOINT, KeptCheckpoint), (EVALUATIONS, KeptJob)):
        for key, value in database.all(kind).items():
            checked_type(model, database.path, f"{kind} {key}", value)


def _checks(folder: Path, database: Database) -> Iterator[FileCheck]:
    recorded: dict[str, str | None] = {RECIPE: None, MANIFEST: None, **database.all(FILES)}
    for name, wanted in sorted(recorded.items()):
        check = _check(folder, name, wanted)
        unrecorded = "the run ended while it was written" if wanted is None else ""
        yield FileCheck(name, check, "" if check else unrecorded)
    for name in (kind for kind in database.kinds() if kind.endswith(".jsonl")):
        yield FileCheck(name, _check(folder, name, digest(lines_file(database.all(name).values()))))
    for name in ("report.html", "log.txt"):
        if (folder / name).exists():
            yield FileCheck(name, note="has no digest; nothing reads it")


def _check(folder: Path, name: str, recorded: str | None) -> str | None:
    try:
        if not (folder / name).resolve().is_relative_to(folder.resolve()):
            raise DamagedError("it is named there and leads out of the folder")
        file_of_run(folder / name, recorded)
    except DamagedError as error:
        return str(error)
    return None
