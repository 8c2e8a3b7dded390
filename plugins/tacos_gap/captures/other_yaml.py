"""YAML that says something else than ``captures.yaml`` does, and what to name in its place."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

from tacos_framework import Fault
from tacos_gap.captures.missing import BEGIN, FILE

_MARK = "tacos_captures"
_OWN = {_MARK, "camera", "captures", "noise"}


def something_else(path: Path, data: Any) -> Fault | None:
    """The fault of a file that is not of captures; None where it may be, or be meant to be."""
    expected = f"a folder of captures, whose {FILE} begins with {_MARK}: 1"
    if data is None:
        return Fault(str(path), "this file is empty", expected, BEGIN)
    if (isinstance(data, dict) and _MARK in data) or not (looks := _looks_like(data)):
        return None
    beside = path.parent / FILE
    remedy = f"Name the folder {path.parent}." if beside != path and beside.is_file() else BEGIN
    if looks.startswith("a recipe"):
        remedy = f"{remedy} A recipe is run by `tacos-run {shlex.quote(str(path))}`."
    return Fault(str(path), f"this is no captures file: it looks like {looks}", expected, remedy)


def _looks_like(data: Any) -> str:
    """Kind of a file by its keys; empty where they are those of captures, or say nothing."""
    if isinstance(data, list):
        effects = data and all(isinstance(each, dict) and "use" in each for each in data)
        return "a list of effects, as --with takes" if effects else "a list"
    if not isinstance(data, dict):
        return "text without keys"
    if not data:
        return ""
    if "tacos" in data:
        return f"a recipe, of {data['use']}" if "use" in data else "a recipe, of a study"
    for key, looks in (
        ("photon_dn", "a calibration of noise"),
        ("effects", "a list of effects, as --with takes"),
        ("cameras", "a catalog of cameras"),
        ("parts", "a catalog of parts"),
    ):
        if key in data:
            return looks
    if _OWN & data.keys():
        return ""
    return f"something with the keys {', '.join(map(str, list(data)[:4]))}{', ...' * (len(data) > 4)}"
