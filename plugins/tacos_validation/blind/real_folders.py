"""Real captures of known truth that somebody has made: a folder of folders, with a ``truth.json``."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from tacos_validation.blind.generators.specifications import CAPTURES
from tacos_validation.blind.judgement import KnownTruth, read_known


@dataclass(frozen=True)
class RealCase:
    name: str
    known: KnownTruth
    write: Callable[[Path], None]

    def truth(self) -> dict[str, Any]:
        return {
            "specification": {
                "tier": "T5",
                "captures": "real",
                "severity": None,
                "notes": {},
                "variants": {},
                "nuisance": "",
            },
            "withheld": [{"effect": name, "parameters": {}, "units": None} for name in self.known.accept[:1]],
            "known": self.known.as_data(),
        }


def real_folders(folder: Path, effects: Sequence[str]) -> list[RealCase]:
    """The cases of a folder of folders of captures; see `read_known` for how their truth is told.

    Raises UserError when a ``truth.json`` cannot be used.
    """
    return [
        RealCase(f"{folder.name}, {name}", known, partial(_copied, source=folder / name))
        for name, known in sorted(read_known(folder, effects).items())
    ]


def _copied(out: Path, source: Path) -> None:
    shutil.copytree(source, out / CAPTURES, ignore=shutil.ignore_patterns("truth.json"))
