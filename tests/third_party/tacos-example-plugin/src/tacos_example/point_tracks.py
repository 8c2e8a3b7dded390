"""The front end of visual odometry: corners followed from frame to frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from tacos_framework import Camera, Episode, FrameBatch, Settings, setting

from tacos_example.checkerboard import grey_image


@dataclass(frozen=True)
class Motion:
    """Corners seen in two consecutive frames of a walk."""

    before_px: NDArray[np.float32]
    after_px: NDArray[np.float32]
    """(K, 2) columns and rows of the same corners in the earlier and in the later frame [px]."""
    before_from_after: NDArray[np.float64]
    """(4, 4) true pose of the camera in the later frame, seen from the earlier one [m]."""


@dataclass(frozen=True)
class Tracks:
    """Motions of the first camera in a batch of frames; the first frame of a walk has none before it."""

    episode: Episode
    camera: Camera
    motions: tuple[Motion, ...]


class PointTracks:
    """Finds corners (Shi and Tomasi 1994) and follows them (Lucas and Kanade 1981).

    A corner that does not return to where it began when it is followed back is dropped.
    """

    class Config(Settings):
        corners: int = setting(200, help="Corners followed at most.", ge=8, le=5000)
        window_px: int = setting(15, help="Width of the window that is compared.", unit="px", ge=5, le=63)
        return_px: float = setting(1.0, help="Farthest that a corner may return off.", unit="px", gt=0)

    def __init__(self, config: Config) -> None:
        self.config = config

    def transform(self, frames: FrameBatch, *, memory: dict[str, Any]) -> Tracks:
        """The motions of a batch; `memory` holds the frame before it."""
        motions = []
        for walk, grey, pose in _frames(frames):
            if memory.get("walk") == walk:
                motions.append(self._motion(memory["grey"], grey, np.linalg.inv(memory["pose"]) @ pose))
            memory.update(walk=walk, grey=grey, pose=pose)
        return Tracks(frames.episode, frames.capture.views[0].camera, tuple(motions))

    def _motion(
        self, before: NDArray[np.uint8], after: NDArray[np.uint8], before_from_after: NDArray[np.float64]
    ) -> Motion:
        start = cv2.goodFeaturesToTrack(before, self.config.corners, qualityLevel=0.01, minDistance=5)
        if start is None:
            nowhere = np.empty((0, 2), np.float32)
            return Motion(nowhere, nowhere, before_from_after)
        window = (self.config.window_px, self.config.window_px)
        end, found, _ = cv2.calcOpticalFlowPyrLK(before, after, start, None, winSize=window)
        back, returned, _ = cv2.calcOpticalFlowPyrLK(after, before, end, None, winSize=window)
        off_px = np.linalg.norm(back - start, axis=-1)
        kept = ((found == 1) & (returned == 1) & (off_px <= self.config.return_px))[:, 0]
        return Motion(start[kept, 0], end[kept, 0], before_from_after)


def _frames(frames: FrameBatch) -> Iterator[tuple[int, NDArray[np.uint8], NDArray[np.float64]]]:
    """For each frame of the first camera its walk, the grey image, and the true pose."""
    poses = frames.capture.views[0].world_from_camera
    for walk, image, pose in zip(frames.episode.walk, frames.images[0], poses, strict=True):
        yield int(walk), grey_image(image, frames.black_level_dn, frames.white_level_dn), pose
