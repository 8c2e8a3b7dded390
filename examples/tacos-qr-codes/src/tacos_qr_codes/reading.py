"""How many QR codes a camera reads on its way past them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

import cv2
from tacos_framework import FrameBatch, Scores, ScoreScale, Settings, State, setting

CLASS_NAME = "qr-code"


class QrCodes:
    """Reads every frame of one camera by OpenCV's detector, and counts labels rather than frames.

    ``read_rate``
        Labels of the world that were read rightly at least once, over all its labels; higher is better.
    ``frames_per_label``
        Frames in which a label was read, on average over all labels; higher leaves more room for error.

    A world without labels (objects of the class ``qr-code``, called by what their codes say) has no scores.
    """

    class Config(Settings):
        """Settings of the task."""

        camera: int = setting(0, help="Which camera of the rig reads.", ge=0)
        enlarged: int = setting(
            2, help="Frames are enlarged by this first: the detector itself reduces large ones.", ge=1, le=4
        )

    wants: ClassVar[Literal["grey"]] = "grey"
    scores: ClassVar[tuple[str, ...]] = ("read_rate", "frames_per_label")
    score_scales: ClassVar[Mapping[str, ScoreScale]] = {"read_rate": "share"}
    margins: ClassVar[Mapping[str, float]] = {"read_rate": 0.02}

    def __init__(self, config: Config) -> None:
        self.config = config

    def begin(self, *, state: State | None) -> Reader:
        """A reader for one episode."""
        return Reader(self.config)


class Reader:
    """Keeps what was read, not the frames."""

    def __init__(self, config: QrCodes.Config) -> None:
        self._config = config
        self._detector = cv2.QRCodeDetector()
        self._labels: set[str] = set()
        self._read: list[str] = []

    def update(self, frames: FrameBatch) -> None:
        """Read the next batch."""
        by, things = self._config.enlarged, frames.episode.world.objects
        self._labels |= {thing.name for thing in things if thing.class_name == CLASS_NAME}
        for image in frames.images[self._config.camera]:
            large = cv2.resize(image, None, fx=by, fy=by, interpolation=cv2.INTER_CUBIC)
            found, texts, _, _ = self._detector.detectAndDecodeMulti(large)
            self._read += self._labels.intersection(texts) if found else []

    def scores(self) -> Scores:
        """The counts over the number of labels."""
        if not (count := len(self._labels)):
            return {}
        return {"read_rate": len(set(self._read)) / count, "frames_per_label": len(self._read) / count}
