"""The text of ``captures.yaml`` for imported photographs, with comments on what was guessed."""

from __future__ import annotations

import shlex
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from tacos_framework import to_yaml
from tacos_gap.photographs.camera import CameraFound

_HEADER = """\
Written by `tacos captures import`. Correct here what is wrong, then: tacos captures check {folder}
Nothing is simulated: each capture expects of its target what the pictures themselves tell of it.
"""


def folder_text(
    folder: str, camera: CameraFound, captures: Sequence[Mapping[str, Any]], doubts: Sequence[str]
) -> str:
    """Text that `read_captures` reads.

    Parameters
    ----------
    folder
        Its name, for the header.
    camera
        The entry `camera`, each value with where it is from.
    captures
        The entries of `captures`.
    doubts
        Sentences on what is unsure; they become comments.
    """
    lines = [_comment(line) for line in _HEADER.format(folder=shlex.quote(folder)).splitlines()]
    if doubts:
        lines += ["#", "# Unsure of:"]
        lines += [_comment(doubt, "- ", "  ") for doubt in doubts]
    lines += ["tacos_captures: 1", "camera:"]
    for key, value in camera.entry.items():
        line = "  " + to_yaml({key: value}).strip()
        lines.append(f"{line.ljust(36)} # {camera.source[key]}" if key in camera.source else line)
    lines.append("noise: unknown".ljust(36) + "   # estimated from repeated frames")
    return "\n".join(lines) + "\n" + to_yaml({"captures": list(captures)}, flow_style=None)


def _comment(text: str, first: str = "", rest: str = "") -> str:
    return textwrap.fill(
        text, 108, initial_indent=f"# {first}", subsequent_indent=f"# {rest}", break_on_hyphens=False
    )
