"""YOLO: a line a box, beside each image."""

from __future__ import annotations

from typing import ClassVar

from tacos_export.dataset.frame import (
    Dataset,
    box_of,
    labelled_classes,
    photograph,
    visible_objects,
    write_image,
    write_lines,
)
from tacos_framework import FrameBatch, to_yaml


class YoloWriter:
    """``images/``, ``labels/`` with lines ``class x y width height``, and ``data.yaml``.

    Classes count from 0; x and y are the middle of the box of visible pixels, and all four are shares of the
    image's width and height. Images without labelled things have an empty file. ``data.yaml`` names one
    folder for training and validation: frames of one trip are alike, unseen ones come of another ``--seed``.

    Source: Redmon et al. 2016, "You only look once", CVPR, in the layout of darknet and Ultralytics.
    """

    eight_bits: ClassVar[bool] = True

    def __init__(self, dataset: Dataset) -> None:
        self._dataset = dataset
        self._classes: list[str] = []

    def add(self, index: int, frame: FrameBatch) -> None:
        world, out = frame.episode.world, self._dataset.out
        self._classes = self._classes or labelled_classes(world)
        for i, view in enumerate(frame.capture.views):
            name = f"{view.camera.name}_{index:06d}"
            write_image(out / "images" / f"{name}.png", photograph(frame, i, self._dataset.encoding))
            lines = []
            for thing, mask in visible_objects(view, world):
                left, top, right, bottom = box_of(mask)
                height, width = mask.shape
                shares = (
                    (left + right + 1) / 2 / width,
                    (top + bottom + 1) / 2 / height,
                    (right + 1 - left) / width,
                    (bottom + 1 - top) / height,
                )
                number = self._classes.index(world.objects[thing].class_name)
                lines.append(f"{number} " + " ".join(f"{share:.6f}" for share in shares))
            write_lines(out / "labels" / f"{name}.txt", lines)

    def close(self) -> None:
        data = {"train": "images", "val": "images", "names": dict(enumerate(self._classes))}
        (self._dataset.out / "data.yaml").write_text(to_yaml(data), encoding="utf-8")
