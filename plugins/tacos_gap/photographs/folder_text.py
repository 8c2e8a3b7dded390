"""The text of ``captures.yaml`` for imported photographs, with comments on what was guessed."""

from __future__ import annotations

import shlex
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from tacos_framework import to_yaml
from tacos_gap.photographs.camera import CameraFound
from tacos_gap.photographs.given import Guess

_HEADER = """\
Written by `tacos captures import`. Correct faults here, then: tacos captures check {folder}
Nothing is simulated: the expectation of each capture is estimated from its own pictures.
"""

_GUESSED = {"kinds": "kind {}", "exposures_ms": "exposure_ms is left open"}


def folder_text(
    folder: str,
    camera: CameraFound,
    captures: Sequence[Mapping[str, Any]],
    guesses: Sequence[Guess],
    doubts: Sequence[str],
) -> str:
    """Text that `read_captures` reads.

    - `folder`: its name, for the header.
    - `camera`: the entry `camera`, each value with where it is from.
    - `captures`: the entries of `captures`.
    - `guesses`: what nothing says; a comment each, also above the captures they are about.
    - `doubts`: sentences on what is unsure; they become comments.
    """
    lines = [_comment(line) for line in _HEADER.format(folder=shlex.quote(folder)).splitlines()]
    for title, texts in (("Guessed:", [guess.text for guess in guesses]), ("Unsure of:", doubts)):
        if texts:
            lines += ["#", f"# {title}", *(_comment(text, "- ", "  ") for text in texts)]
    lines += ["tacos_captures: 1", "camera:"]
    for key, value in camera.entry.items():
        line = "  " + to_yaml({key: value}).strip()
        lines.append(f"{line.ljust(36)} # {camera.source[key]}" if key in camera.source else line)
    lines.append("noise: unknown".ljust(36) + "   # estimated from repeated frames")
    lines.append("captures:")
    for entry in captures:
        files = {name.rpartition("/")[2] for name in entry["real"]}
        lines += [
            _comment(f"a guess: {_GUESSED[guess.key].format(guess.assumed)}")
            for guess in guesses
            if guess.key in _GUESSED and files & set(guess.pictures)
        ]
        lines.append(to_yaml([entry], flow_style=None).rstrip())
    return "\n".join(lines) + "\n"


def _comment(text: str, first: str = "", rest: str = "") -> str:
    return textwrap.fill(
        text, 108, initial_indent=f"# {first}", subsequent_indent=f"# {rest}", break_on_hyphens=False
    )
