"""Frames of one camera as another program left them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray


@dataclass(frozen=True)
class FoundFrame:
    """One frame: its name, stamp [ns], exposure [ms] where it is known, and how to read it."""

    name: str
    stamp_ns: int
    exposure_ms: float | None
    read: Callable[[], NDArray[Any]]


@dataclass(frozen=True)
class FoundRecording:
    """Frames in the order of their table."""

    layout: str
    frames: tuple[FoundFrame, ...]
    camera: str = ""  # text for ``camera.yaml``; empty where nothing is known of the lens
    response: str = ""  # text for ``response.txt``; empty where it is unknown
