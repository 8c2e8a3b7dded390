"""A rectified pair of cameras: what a point's depth has to do with its disparity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, CandidateFailed

ALIGNED = 1e-6
"""Tolerance of cameras that are not quite parallel and side by side, as a share of the baseline or of the
pixels [1].
"""


@dataclass(frozen=True)
class StereoPair:
    """Two equal, parallel cameras side by side.

    A point at depth Z lies ``d = f b / Z`` pixels further left in the right image (the paper's rectified
    stereo). Log errors of depth and of disparity over baseline are therefore equal.
    """

    left: int
    right: int
    """Indices of the two in the rig."""
    width_px: int
    height_px: int
    """Size of both images [px]."""
    focal_length_px: float
    """Focal length of both [px]."""
    baseline_m: float
    """Distance of their optical centres [m]."""

    @property
    def disparity_metre(self) -> float:
        """Disparity of a point 1 m away: ``f b`` [px m]."""
        return self.focal_length_px * self.baseline_m

    def disparity_px(self, depth_m: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
        """Disparity of points at a depth [m]; 0 where it is infinite [px]."""
        return (self.disparity_metre / np.asarray(depth_m)).astype(np.float32)

    def depth_m(self, disparity_px: NDArray[np.floating[Any]], *, max_depth_m: float) -> NDArray[np.float64]:
        """Depth of points of a disparity [px], at most `max_depth_m`; that too where there is none [m]."""
        least = self.disparity_metre / max_depth_m
        return self.disparity_metre / np.maximum(np.asarray(disparity_px, np.float64), least)


def stereo_pair(
    cameras: Sequence[Camera],
    *,
    left: str | None,
    right: str | None,
    smallest_px: int,
    largest_px: float,
    max_depth_m: float,
) -> StereoPair:
    """The pair among the cameras of a rig.

    - `cameras`: all cameras of the rig.
    - `left`, `right`: names of the two; the first and the second camera where they are None.
    - `smallest_px`: width and height an image needs [px].
    - `largest_px`: disparities from here on cannot be found [px].
    - `max_depth_m`: largest depth that counts [m].

    Raises `CandidateFailed` when there is no such pair: in a sentence, what is wrong with the cameras.
    """
    names = [camera.name for camera in cameras]
    if len(cameras) < 2:
        raise CandidateFailed(f"stereo needs two cameras, and the rig has one: {names[0]} (see rig.stereo)")
    for name in (left, right):
        if name is not None and name not in names:
            raise CandidateFailed(f"the rig has no camera {name!r}, only {', '.join(names)}")
    i = 0 if left is None else names.index(left)
    j = 1 if right is None else names.index(right)
    if fault := _fault(cameras[i], cameras[j], smallest_px):
        raise CandidateFailed(fault)
    pair = StereoPair(
        left=i,
        right=j,
        width_px=cameras[i].width_px,
        height_px=cameras[i].height_px,
        focal_length_px=cameras[i].focal_length_px,
        baseline_m=float(_right_in_left(cameras[i], cameras[j])[0, 3]),
    )
    if (least_px := pair.disparity_metre / max_depth_m) >= largest_px:
        raise CandidateFailed(
            f"a baseline of {pair.baseline_m:g} m at {cameras[i].hfov_deg:.3g} deg gives disparities of "
            f"{least_px:.0f} px and more up to {max_depth_m:g} m, and none below {largest_px:g} px can be "
            "found"
        )
    return pair


def _right_in_left(left: Camera, right: Camera) -> NDArray[np.float64]:
    """(4, 4) pose of the right camera in the frame of the left [m]."""
    return np.linalg.inv(left.agent_from_camera) @ right.agent_from_camera


def _fault(left: Camera, right: Camera, smallest_px: int) -> str | None:
    """Why two cameras are no rectified pair, in a sentence; None when they are one."""
    names = f"cameras {left.name!r} and {right.name!r}"
    sizes = [(camera.width_px, camera.height_px) for camera in (left, right)]
    if sizes[0] != sizes[1] or not np.allclose(left.intrinsics, right.intrinsics, rtol=ALIGNED):
        return f"{names} differ in size, focal length or principal point: stereo needs two equal cameras"
    if not (left.lens.is_pinhole and right.lens.is_pinhole):
        lens = (right if left.lens.is_pinhole else left).lens
        kind = f"{lens.projection} lenses" if not lens.is_rectilinear else "distorted or dark corners"
        return f"{names} have {kind}: stereo needs rectified images, those of pinholes"
    if min(sizes[0]) < smallest_px:
        return (
            f"images of {left.width_px} x {left.height_px} px are too small for stereo: "
            f"{smallest_px} x {smallest_px} px are needed"
        )
    pose = _right_in_left(left, right)
    across, *aside = pose[:3, 3]
    if not across > 0:
        distance = f"{across:g} m to the right of {left.name!r}"
        return f"{names} have no baseline: {right.name!r} stands {distance}, it must be above 0"
    turned = np.abs(pose[:3, :3] - np.eye(3)).max()
    if turned > ALIGNED or math.hypot(*aside) > ALIGNED * across:
        return f"{names} are not parallel and side by side: their images have to be rectified first"
    return None
