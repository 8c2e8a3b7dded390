"""Frames of a video file."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Fault, UserError


class Video:
    """A video, its frames read in their order.

    Raises `UserError` when it is no regular file, or none of its frames can be read.
    """

    def __init__(self, path: Path) -> None:
        if not path.is_file():
            raise UserError(Fault(str(path), "is no file", "a video"))
        self._path = path
        self._opened: cv2.VideoCapture | None = None
        video = cv2.VideoCapture(str(path))
        stamps = []
        while video.grab():
            stamps.append(round(video.get(cv2.CAP_PROP_POS_MSEC) * 1e6))
        video.release()
        if not stamps:
            raise UserError(Fault(str(path), "holds no frame that OpenCV can read", "a video"))
        self.stamp_ns = stamps

    def next_grey(self) -> NDArray[np.uint8]:
        """The next (H, W) frame in grey.

        Raises `UserError` when it cannot be decoded.
        """
        self._opened = self._opened or cv2.VideoCapture(str(self._path))
        taken, image = self._opened.read()
        if not taken:
            raise UserError(Fault(str(self._path), "holds a frame that cannot be decoded", "whole frames"))
        return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), np.uint8)
