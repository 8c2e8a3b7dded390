"""Content of a folder without ``captures.yaml``, and the command to type."""

from __future__ import annotations

import shlex
from itertools import islice
from pathlib import Path

from tacos_files.camera_images import PICTURE_SUFFIXES
from tacos_framework import Fault

FILE = "captures.yaml"

BEGUN = "captures_begun.jsonl"
"""What ``tacos captures simulate`` keeps of the captures it has taken, until all of them are there."""

BEGIN = "`tacos captures guide` says what to photograph, `tacos captures import` makes the folder."

_LOOKED_AT = 5000
"""Files and folders looked at: a folder may be somebody's whole disk."""


def nothing_to_read(folder: Path) -> Fault:
    if not folder.exists():
        return Fault(str(folder), "there is no such folder", f"a folder of captures, with {FILE}", BEGIN)
    if folder.is_file():
        remedy = _sorted_by_import(folder.parent) if folder.suffix.lower() in PICTURE_SUFFIXES else ""
        return Fault(str(folder), "this is a file", f"a folder of captures, with {FILE}", remedy)
    shown = shlex.quote(str(folder))
    if (folder / BEGUN).is_file():
        return Fault(
            str(folder),
            f"there is no {FILE}: the simulator that takes these captures is not done, or was ended",
            "a folder of captures",
            f"Go on with `tacos captures simulate {shlex.quote(str(folder / 'recipe.yaml'))} --out {shown} "
            f"--resume`.",
        )
    below = list(islice(folder.rglob("*"), _LOOKED_AT))
    if inner := [path.parent for path in below if path.name == FILE]:
        named = ", ".join(str(path) for path in sorted(inner)[:3])
        return Fault(str(folder), f"there is no {FILE}", "a folder of captures", f"Name one of: {named}.")
    if pictures := sorted(p for p in below if p.suffix.lower() in PICTURE_SUFFIXES and p.is_file()):
        return Fault(
            str(folder),
            f"there is no {FILE}, but photographs ({pictures[0].name}{', ...' * (len(pictures) > 1)})",
            f"a folder of captures, whose {FILE} says what each photograph shows",
            _sorted_by_import(folder),
        )
    return Fault(str(folder), f"there is no {FILE}", "a folder of captures", BEGIN)


def _sorted_by_import(photographs: Path) -> str:
    beside = f"{photographs.resolve().name or 'my'}_captures"
    out = photographs.parent / beside if photographs.name not in ("", "..") else photographs / ".." / beside
    given, made = (shlex.quote(str(path)) for path in (photographs, out))
    return f"Sort them with `tacos captures import {given} --out {made}`, then name the folder it makes."
