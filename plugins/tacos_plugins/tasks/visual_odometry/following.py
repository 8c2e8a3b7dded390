"""Points of one image found again in another: by patches or by descriptors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_plugins.tasks.followed_features import Features, extract_spread, match

Method = Literal["klt", "orb"]

Matches = tuple[NDArray[np.intp], NDArray[np.float32]]
"""(N,) indices of points of the one image, and where the other shows them, (N, 2) [px]."""


@dataclass(frozen=True, eq=False)
class Marked:
    """An image with its points (K, 2) [px], and what its follower needs of it."""

    points_px: NDArray[np.float32]
    content: Any


class Follower(Protocol):
    """A way to follow points."""

    def marked(self, grey: NDArray[np.uint8]) -> Marked:
        """An (H, W) image with its points."""
        ...

    def matches(self, first: Marked, second: Marked) -> Matches:
        """The points of the first image that the second shows."""
        ...

    def upside_down(self, grey: NDArray[np.uint8]) -> Marked:
        """The image mirrored top to bottom: what `matches` finds there it finds by chance."""
        ...


@dataclass(frozen=True)
class PatchFollower:
    """Corners (Shi and Tomasi 1994) whose patches are followed (Lucas and Kanade 1981) forth and back."""

    points: int
    """Corners of an image, at least `apart_px` from one another [1]."""
    apart_px: float
    quality: float = 0.01
    window_px: int = 21
    levels: int = 4
    """Edge of the patch [px], and halvings of the image in which it is looked for first."""
    returns_px: float = 0.5
    """A patch that comes back farther than this from where it started is lost [px]."""

    def marked(self, grey: NDArray[np.uint8]) -> Marked:
        found = cv2.goodFeaturesToTrack(grey, self.points, self.quality, self.apart_px)
        points = np.zeros(0) if found is None else np.asarray(found)
        return Marked(points.reshape(-1, 2).astype(np.float32), grey)

    def matches(self, first: Marked, second: Marked) -> Matches:
        if not len(first.points_px):
            return np.empty(0, np.intp), np.empty((0, 2), np.float32)
        there, found = self._followed(first.content, second.content, first.points_px)
        back, returned = self._followed(second.content, first.content, there)
        kept = found & returned & (np.linalg.norm(back - first.points_px, axis=1) < self.returns_px)
        return np.flatnonzero(kept), there[kept]

    def upside_down(self, grey: NDArray[np.uint8]) -> Marked:
        return Marked(np.empty((0, 2), np.float32), cv2.flip(grey, 0))

    def _followed(
        self, first: NDArray[np.uint8], second: NDArray[np.uint8], points_px: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        there, found, _ = cv2.calcOpticalFlowPyrLK(  # type: ignore[call-overload] # None starts at the points
            first, second, points_px, None, winSize=(self.window_px, self.window_px), maxLevel=self.levels
        )
        return np.asarray(there), found.ravel() > 0


@dataclass(frozen=True)
class DescriptorFollower:
    """ORB features, an even share of each cell of the image, matched by mutual nearest neighbours."""

    points: int
    cells: tuple[int, int] = (8, 6)
    fast_threshold: int = 12

    def marked(self, grey: NDArray[np.uint8]) -> Marked:
        detector = cv2.ORB.create(nfeatures=4 * self.points, fastThreshold=self.fast_threshold)
        features = extract_spread(detector, grey, cells=self.cells, most=self.points)
        return Marked(features.points_px, features)

    def matches(self, first: Marked, second: Marked) -> Matches:
        ours, theirs = _features(first), _features(second)
        found = match(ours, theirs)
        index = np.array([each.queryIdx for each in found], np.intp)
        return index, theirs.points_px[[each.trainIdx for each in found]].reshape(-1, 2)

    def upside_down(self, grey: NDArray[np.uint8]) -> Marked:
        return self.marked(np.asarray(cv2.flip(grey, 0), np.uint8))


def _features(image: Marked) -> Features:
    features: Features = image.content
    return features


def follower(method: Method, *, points: int, apart_px: float) -> Follower:
    if method == "klt":
        return PatchFollower(points, apart_px)
    return DescriptorFollower(points)
