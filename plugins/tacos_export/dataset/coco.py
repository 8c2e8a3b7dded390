"""COCO: boxes and masks of what is labelled, with depth beside the images."""

from __future__ import annotations

import json
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_export.conventions import depth_codes
from tacos_export.dataset.frame import (
    Dataset,
    box_of,
    labelled_classes,
    photograph,
    visible_objects,
    write_image,
)
from tacos_export.dataset.polygons import polygons
from tacos_framework import FrameBatch

DEPTH_CODES_PER_M = 1000.0
"""Depth files are in millimetres."""


class CocoWriter:
    """``images/``, ``depth/`` (16-bit millimetres), ``annotations.json`` and ``polygons.json``.

    Both have the same boxes and masks: as run lengths, uncompressed, which `pycocotools.mask.frPyObjects`
    reads, and as polygons, for programs that know no others. Images of all cameras stand in one list;
    ``camera`` and ``frame`` of an image tell them apart.

    Source: Lin et al. 2014, "Microsoft COCO: Common Objects in Context", ECCV; cocodataset.org, "Data
    format".
    """

    eight_bits: ClassVar[bool] = True

    def __init__(self, dataset: Dataset) -> None:
        self._dataset = dataset
        self._images: list[dict[str, Any]] = []
        self._annotations: list[dict[str, Any]] = []
        self._polygons: list[list[list[float]]] = []
        self._categories: dict[str, int] = {}

    def add(self, index: int, frame: FrameBatch) -> None:
        world = frame.episode.world
        self._categories = self._categories or {n: i for i, n in enumerate(labelled_classes(world), start=1)}
        for i, view in enumerate(frame.capture.views):
            name = f"{view.camera.name}_{index:06d}.png"
            write_image(self._dataset.out / "images" / name, photograph(frame, i, self._dataset.encoding))
            write_image(self._dataset.out / "depth" / name, depth_codes(view.depth_m[0], DEPTH_CODES_PER_M))
            image_id = len(self._images) + 1
            self._images.append(
                {
                    "id": image_id,
                    "file_name": name,
                    "width": view.camera.width_px,
                    "height": view.camera.height_px,
                    "camera": view.camera.name,
                    "frame": index,
                }
            )
            for thing, mask in visible_objects(view, world):
                left, top, right, bottom = box_of(mask)
                self._annotations.append(
                    {
                        "id": len(self._annotations) + 1,
                        "image_id": image_id,
                        "category_id": self._categories[world.objects[thing].class_name],
                        "object_id": thing,
                        "bbox": [left, top, right - left + 1, bottom - top + 1],
                        "area": int(mask.sum()),
                        "iscrowd": 0,
                        "segmentation": {"size": list(mask.shape), "counts": run_lengths(mask)},
                    }
                )
                self._polygons.append(polygons(mask))

    def close(self) -> None:
        outlined = [
            {**each, "segmentation": rings}
            for each, rings in zip(self._annotations, self._polygons, strict=True)
        ]
        listed = [{"id": number, "name": name} for name, number in self._categories.items()]
        for name, masked in (("annotations", self._annotations), ("polygons", outlined)):
            data = {"images": self._images, "annotations": masked, "categories": listed}
            (self._dataset.out / f"{name}.json").write_text(json.dumps(data) + "\n", encoding="utf-8")


def run_lengths(mask: NDArray[np.bool_]) -> list[int]:
    """Lengths of runs down the columns, beginning with a run of background, as COCO counts.

    >>> run_lengths(np.array([[1, 0], [1, 1]], bool))
    [0, 2, 1, 1]
    """
    flat = mask.ravel(order="F")
    changes = np.flatnonzero(flat[1:] != flat[:-1]) + 1
    lengths = np.diff(np.concatenate([[0], changes, [len(flat)]])).tolist()
    return [0, *lengths] if flat[0] else lengths
