"""Objects to detect in a frame: boxes around the visible pixels of each object."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import World


@dataclass(frozen=True, eq=False)
class Labels:
    """The objects of a frame."""

    boxes_px: NDArray[np.float32]
    """(K, 4) float32 left, top, right and bottom edge. A pixel covers its index to its index plus one, so an
    object of one pixel at (3, 5) has the box 3, 5, 4, 6 [px].
    """
    classes: NDArray[np.int64]
    """(K,) int64 index into the classes that are looked for, from 1; 0 is the background."""
    counts: NDArray[np.bool_]
    """(K,) bool: large enough to be asked for. Finding one that is not is neither right nor wrong."""

    def __len__(self) -> int:
        return len(self.classes)

    def counted(self) -> Labels:
        return Labels(self.boxes_px[self.counts], self.classes[self.counts], self.counts[self.counts])

    def mirrored(self, width_px: int) -> Labels:
        left, top, right, bottom = self.boxes_px.T
        boxes = np.stack([width_px - right, top, width_px - left, bottom], axis=1)
        return Labels(boxes, self.classes, self.counts)


def class_numbers(world: World, classes: Sequence[str]) -> NDArray[np.int64]:
    """For each object id of a world the number of its class, from 1; 0 where it is not looked for."""
    number = {name: i for i, name in enumerate(classes, start=1)}
    return np.array([number.get(thing.class_name, 0) for thing in world.objects], np.int64)


def frame_labels(
    object_id: NDArray[np.int32],
    class_of_object: NDArray[np.int64],
    *,
    minimum_area_px: int,
    minimum_share: float,
) -> Labels:
    """The objects of a frame, from the ids at its pixels.

    A box encloses the pixels at which an object is in sight: what hides it cuts it, and so does the border.

    - `object_id`: (H, W) int32 ids.
    - `class_of_object`: (objects,) int64 number of each id's class, 0 where it is not looked for.
    - `minimum_area_px`: visible pixels an object must have to count [px].
    - `minimum_share`: share of the image it must cover to count, so that the truth does not depend on the
      number of pixels.

    >>> ids = np.array([[0, 0, 0], [0, 2, 2], [0, 2, 1]], np.int32)
    >>> found = frame_labels(ids, np.array([0, 1, 1]), minimum_area_px=2, minimum_share=0.0)
    >>> found.boxes_px.tolist()
    [[2.0, 2.0, 3.0, 3.0], [1.0, 1.0, 3.0, 3.0]]
    >>> found.counts.tolist()
    [False, True]
    """
    height, width = object_id.shape
    row, left, right, ids = _runs(object_id)
    asked = np.flatnonzero(class_of_object[ids])
    order = asked[np.argsort(ids[asked], kind="stable")]
    present, first = np.unique(ids[order], return_index=True)
    boxes = np.empty((len(present), 4), np.float32)
    area_px = np.zeros(len(present), np.intp)
    if len(present) > 0:
        boxes[:, 0], boxes[:, 1] = np.minimum.reduceat(left[order], first), row[order][first]
        boxes[:, 2] = np.maximum.reduceat(right[order], first)
        boxes[:, 3] = np.maximum.reduceat(row[order], first) + 1
        area_px = np.add.reduceat((right - left)[order], first)
    counts = (area_px >= minimum_area_px) & (area_px >= minimum_share * height * width)
    return Labels(boxes, class_of_object[present], counts)


def _runs(object_id: NDArray[np.int32]) -> tuple[NDArray[np.integer], ...]:
    """Runs of equal ids along rows, first row first: row, first column, the column after the last, and id."""
    height, width = object_id.shape
    begins = np.ones((height, width), dtype=bool)
    np.not_equal(object_id[:, 1:], object_id[:, :-1], out=begins[:, 1:])
    start = np.flatnonzero(begins)
    row, left = np.divmod(start, max(1, width))
    return row, left, left + np.diff(start, append=height * width), object_id.reshape(-1)[start]
