"""Average precision, by pycocotools."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

from tacos_framework import Scores
from tacos_plugins.tasks.faster_rcnn.labels import Labels

COUNTED, NOT_COUNTED = 1.0, 0.0
"""Stand for the areas of true boxes: COCO's way to leave some out is a range of areas."""


@dataclass(frozen=True, eq=False)
class Detections:
    boxes_px: NDArray[np.float32]
    """(K, 4) float32 left, top, right and bottom edge, as in `Labels` [px]."""
    classes: NDArray[np.int64]
    """(K,) int64 number of the class, from 1."""
    confidences: NDArray[np.float32]
    """(K,) float32 in 0..1."""


class AveragePrecision:
    """Average precision over all frames at one overlap, of each class and on average.

    - `classes`: names of the classes, numbered from 1.
    - `detections`: detections of a frame that are looked at, the most confident of each class.
    - `iou`: intersection over union from which a detection has found an object.

    Source: COCO's evaluation: precision interpolated at 101 recalls, averaged. Lin et al. 2014, "Microsoft
    COCO: common objects in context".
    """

    def __init__(self, classes: Sequence[str], *, detections: int = 100, iou: float = 0.5):
        self._classes, self._most, self._iou = tuple(classes), detections, iou
        self._truth: list[dict[str, Any]] = []
        self._found: list[dict[str, Any]] = []
        self._frames = 0

    def add(self, truth: Labels, found: Detections) -> None:
        """Take in a frame; objects that do not count may be found or not."""
        self._frames += 1
        for box, number, counts in zip(
            _corner_and_size(truth.boxes_px), truth.classes, truth.counts, strict=True
        ):
            self._truth.append(
                {
                    "id": len(self._truth) + 1,  # COCO takes 0 for "none"
                    "image_id": self._frames,
                    "category_id": int(number),
                    "bbox": box,
                    "area": COUNTED if counts else NOT_COUNTED,
                    "iscrowd": 0,
                }
            )
        boxes = _corner_and_size(found.boxes_px)
        for box, number, confidence in zip(boxes, found.classes, found.confidences, strict=True):
            self._found.append(
                {
                    "image_id": self._frames,
                    "category_id": int(number),
                    "bbox": box,
                    "score": float(confidence),
                }
            )

    def scores(self, name: str) -> Scores:
        """``name``, the mean over the classes that have objects, and ``name_CLASS`` of each of them.

        Empty where there are no objects at all.
        """
        present = {entry["category_id"] for entry in self._truth if entry["area"] == COUNTED}
        if not present:
            return {}
        of_class = self._precisions() if self._found else dict.fromkeys(present, 0.0)
        named = {f"{name}_{self._classes[number - 1]}": of_class[number] for number in sorted(present)}
        return {name: sum(named.values()) / len(named), **named}

    def _precisions(self) -> dict[int, float]:
        """Average precision of each class number that has objects."""
        numbers = range(1, len(self._classes) + 1)
        with contextlib.redirect_stdout(io.StringIO()):  # it reports on itself
            truth = COCO()
            truth.dataset = {
                "info": {},
                "images": [{"id": i + 1} for i in range(self._frames)],
                "annotations": self._truth,
                "categories": [{"id": number} for number in numbers],
            }
            truth.createIndex()
            evaluation = COCOeval(truth, truth.loadRes([dict(entry) for entry in self._found]), "bbox")
            evaluation.params.iouThrs = np.array([self._iou])
            evaluation.params.maxDets = [self._most]
            evaluation.params.areaRng = [[COUNTED / 2, np.inf]]
            evaluation.params.areaRngLbl = ["counted"]
            evaluation.evaluate()
            evaluation.accumulate()
        precision = evaluation.eval["precision"][0, :, :, 0, 0]  # (recalls, classes); -1 without objects
        return {number: float(precision[:, number - 1].mean()) for number in numbers}


def _corner_and_size(edges_px: NDArray[np.float32]) -> list[list[float]]:
    """Boxes as COCO writes them: left, top, width, height."""
    left, top, right, bottom = edges_px.astype(np.float64).reshape(-1, 4).T
    return np.stack([left, top, right - left, bottom - top], axis=1).tolist()
