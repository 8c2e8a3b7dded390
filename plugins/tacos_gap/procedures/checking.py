"""What is wrong with the settings of a diagnosis, all of it at once and before any work."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from tacos_framework.errors import Fault, UserError
from tacos_framework.settings import check
from tacos_framework.settings.yaml_reader import read_yaml
from tacos_gap.captures.entries import FolderEntry
from tacos_gap.captures.reader import FILE


def check_all(*checks: Callable[[], Any]) -> None:
    """Make every check.

    Raises
    ------
    UserError
        With the faults of all of them.
    """
    faults: list[Fault] = []
    for each in checks:
        try:
            each()
        except UserError as error:
            faults += [fault for fault in error.faults if fault not in faults]
    if faults:
        raise UserError(faults)


def check_captures(folder: str) -> None:
    """Whether a folder holds a sound ``captures.yaml``; its images are read as the diagnosis begins.

    Raises
    ------
    UserError
        With every fault of the file.
    """
    path = Path(folder)
    path = path if path.suffix in (".yaml", ".yml") else path / FILE
    if path.parent.is_dir() and not path.is_file():
        what = f"there is no {path.name}"
        raise UserError(Fault(str(path.parent), what, "a folder of captures", "See the how-to on captures."))
    document = read_yaml(path)
    entry, faults, _ = check(FolderEntry, document.data, document.where)
    if faults or entry is None:
        raise UserError(faults)
