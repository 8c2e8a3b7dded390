"""Share of frames in which a calibration target is found."""

from __future__ import annotations

from typing import ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray
from tacos_framework import FrameBatch, Scores, Settings, State, setting
from tacos_framework.camera import display_image, luminance


class Checkerboard:
    """Looks for a checkerboard in every frame of the first camera.

    ``found_ratio``
        Frames in which all inner corners were found over all frames, in 0..1; higher is better.
    """

    class Config(Settings):
        inner_corners: tuple[int, int] = setting((7, 5), help="Inner corners across and down.")

    scores: ClassVar[tuple[str, ...]] = ("found_ratio",)

    def __init__(self, config: Config) -> None:
        self.config = config

    def begin(self, *, state: State | None) -> CheckerboardScorer:
        """A scorer for one episode."""
        return CheckerboardScorer(self.config.inner_corners)


class CheckerboardScorer:
    """Counts; keeps no frames."""

    def __init__(self, inner_corners: tuple[int, int]) -> None:
        self._inner_corners = inner_corners
        self._found = self._seen = 0

    def update(self, frames: FrameBatch) -> None:
        for image in frames.images[0]:
            grey = grey_image(image, frames.black_level_dn, frames.white_level_dn)
            found, _ = cv2.findChessboardCornersSB(grey, self._inner_corners)
            self._found += int(found)
            self._seen += 1

    def scores(self) -> Scores:
        """The ratio; no score without frames."""
        return {"found_ratio": self._found / self._seen} if self._seen else {}


def grey_image(image: NDArray[np.generic], black_level_dn: float, white_level_dn: float) -> NDArray[np.uint8]:
    """(H, W) uint8 as a person would see a linear (H, W, 1) or (H, W, 3) frame."""
    shown = display_image(image, black_level_dn, white_level_dn)
    return shown[..., 0] if shown.shape[-1] == 1 else np.rint(luminance(shown)).astype(np.uint8)
