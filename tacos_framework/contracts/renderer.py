"""Light on each pixel."""

from __future__ import annotations

from typing import ClassVar, Protocol

from tacos_framework.settings import Settings
from tacos_framework.values import Capture, Episode, Exposure, Rig


class Renderer(Protocol):
    """Gives the light that reaches each pixel, and the truth behind it.

    ``reads`` names the fields of `Camera` and `Exposure` its output depends on: candidates that agree in
    them may share a capture.
    """

    Config: ClassVar[type[Settings]]
    reads: ClassVar[frozenset[str]]

    def capture(self, episode: Episode, *, rig: Rig, exposure: Exposure) -> Capture:
        """One view per camera of the rig for every frame of the batch."""
        ...
