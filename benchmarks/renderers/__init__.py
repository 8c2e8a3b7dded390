"""Renderers that benchmarks compare, each behind one face: a tour goes in, frames of it come out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from renderers.tour import Tour


@dataclass(frozen=True, eq=False)
class Picture:
    """One frame, as a person and a check look at it.

    Parameters
    ----------
    colour
        (H, W, 3) uint8 sRGB.
    depth_m
        (H, W) float32 along the optical axis; beyond the last surface any value above all others [m].
    object_id
        (H, W) int32, or None where they were not asked for.
    """

    colour: NDArray[np.uint8]
    depth_m: NDArray[np.float32]
    object_id: NDArray[np.int32] | None


class Renderer(Protocol):
    """What is timed."""

    def draw(self, frame: int, ids: bool) -> Any:
        """Colour and depth of a frame in memory, in whatever form this renderer gives them; ids on demand."""
        ...

    def picture(self, drawn: Any) -> Picture:
        """What `draw` gave, decoded; not timed."""
        ...


_WHERE = {
    "ours": "renderers.ours:Ours",
    "per-vertex": "renderers.per_vertex:PerVertex",
    "per-vertex, 4 samples": "renderers.per_vertex:multisampled",
    "panda3d": "renderers.panda:Panda",
    "panda3d, 4 samples": "renderers.panda:multisampled",
    "pyrender unlit": "renderers.pyrender_scenes:Pyrender",
    "pyrender lit": "renderers.pyrender_scenes:lit",
}

NAMES = tuple(_WHERE)
"""Names that `make` knows."""


def make(name: str, tour: Tour) -> Renderer:
    """The renderer of a name. Imports late: no process needs the packages of all of them."""
    module, _, factory = _WHERE[name].partition(":")
    of_tour: Callable[[Tour], Renderer] = getattr(import_module(module), factory)
    return of_tour(tour)
