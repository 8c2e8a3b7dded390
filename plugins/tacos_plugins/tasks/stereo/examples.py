"""Pairs of images with the disparity that the rendered depth gives them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import FrameBatch
from tacos_plugins.tasks.stereo.pair import StereoPair


@dataclass(frozen=True, eq=False)
class StereoExample:
    left_dn: NDArray[Any]
    right_dn: NDArray[Any]
    """(H, W, C) uint8 or uint16 linear images [DN]."""
    black_level_dn: float
    white_level_dn: float
    """Pedestal and full scale [DN]."""
    depth_m: NDArray[np.float32]
    """(H, W) float32 truth of the left image; infinite where nothing is [m]."""
    pair: StereoPair

    def cropped(self, width_px: int, height_px: int, rng: np.random.Generator) -> StereoExample:
        """A window of at most this size at a random place, the same in both images."""
        height, width = self.depth_m.shape
        y = int(rng.integers(max(height - height_px, 0) + 1))
        x = int(rng.integers(max(width - width_px, 0) + 1))
        window = np.s_[y : y + height_px, x : x + width_px]
        return replace(
            self, left_dn=self.left_dn[window], right_dn=self.right_dn[window], depth_m=self.depth_m[window]
        )

    def disparity_px(self, *, max_depth_m: float, sky: bool) -> NDArray[np.float32]:
        """(H, W) true disparities [px].

        `max_depth_m`: depths are capped here [m]. `sky`: whether what lies beyond counts as standing there;
        it has the disparity 0 otherwise.
        """
        beyond_m = max_depth_m if sky else np.inf
        return self.pair.disparity_px(np.where(self.depth_m < max_depth_m, self.depth_m, beyond_m))


def stereo_examples(frames: FrameBatch, pair: StereoPair) -> Iterator[StereoExample]:
    """The pairs of a batch, frame by frame."""
    depths_m = frames.capture.views[pair.left].depth_m
    for left, right, depth_m in zip(
        frames.images[pair.left], frames.images[pair.right], depths_m, strict=True
    ):
        yield StereoExample(left, right, frames.black_level_dn, frames.white_level_dn, depth_m, pair)
