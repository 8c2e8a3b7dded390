"""Families of markers, and what is true of those in a world."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import World

CLASS_NAME = "tag"
"""Class of the objects that are markers; each is called by its family and number."""

Family = Literal["apriltag_36h11", "apriltag_16h5", "aruco_4x4_50", "aruco_5x5_100", "aruco_6x6_250"]


def dictionary_of(family: str) -> cv2.aruco.Dictionary:
    name = f"DICT_{family.removeprefix('aruco_').upper()}"
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))


def cells_of(family: str) -> int:
    """Cells along the edge of a marker, black border included; its sheet has one more on each side."""
    return int(dictionary_of(family).markerSize) + 2


@dataclass(frozen=True, eq=False)
class Tag:
    """A marker of a world."""

    object_id: int
    """Index into `World.objects`."""
    family: str
    number: int
    """Number in its family."""
    corners_m: NDArray[np.float64]
    """(4, 3) corners of its black border in the world, clockwise from the upper left as it is read [m]."""

    @property
    def edge_m(self) -> float:
        return float(np.linalg.norm(self.corners_m[1] - self.corners_m[0]))


def tags_of(world: World) -> Iterator[Tag]:
    """The markers of a world: squares of the class ``tag`` called ``family number``."""
    for part in world.parts:
        thing = world.objects[part.object_id]
        if thing.class_name == CLASS_NAME:
            family, _, number = thing.name.rpartition(" ")
            sheet = part.vertices_m.astype(np.float64)[[3, 2, 1, 0]]
            middle, cells = sheet.mean(axis=0), cells_of(family)
            corners = middle + (sheet - middle) * cells / (cells + 2)
            yield Tag(part.object_id, family, int(number), corners)
