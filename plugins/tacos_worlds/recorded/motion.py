"""The motion of a recording's image, measured between its own frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_worlds.recorded.recording import Recording

_SMOOTHED_PX = 16.0
"""Flow is smoothed over this much: parallax of trees stays, errors of single pixels do not [px]."""


@dataclass(frozen=True, eq=False)
class Shot:
    """A frame ready for motion: stamp [s], exposure [ms], and (H/2, W/2) uint8 light per exposure."""

    stamp_s: float
    exposure_ms: float
    grey: NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Motion:
    """Velocity of the image."""

    time_s: NDArray[np.float64]  # (K,) middle of each step [s]
    velocity_px_s: NDArray[np.float32]  # (K, H/2, W/2, 2) velocity along x and y [px/s] at every other pixel

    def at(self, time_s: float) -> NDArray[np.float32]:
        """(H/2, W/2, 2) velocity at a time, linear between steps, constant beyond them [px/s]."""
        if len(self.time_s) == 1:
            return self.velocity_px_s[0]
        after = int(np.clip(np.searchsorted(self.time_s, time_s), 1, len(self.time_s) - 1))
        before_s, after_s = self.time_s[after - 1 : after + 1]
        share = np.float32(np.clip((time_s - before_s) / (after_s - before_s), 0, 1))
        return np.asarray((1 - share) * self.velocity_px_s[after - 1] + share * self.velocity_px_s[after])


@dataclass(frozen=True, eq=False)
class Steps:
    """Displacements between consecutive shots: (K, H/2, W/2, 2) [px]."""

    shots: Sequence[Shot]
    moved_px: NDArray[np.float32]

    def motion(self, stamp_after_middle: float) -> Motion:
        """Velocities, where stamps lie that many exposure times after the middle of the exposure."""
        middle_s = self._middles_s(stamp_after_middle)
        duration_s = np.diff(middle_s).astype(np.float32)
        return Motion((middle_s[1:] + middle_s[:-1]) / 2, self.moved_px / duration_s[:, None, None, None])

    def _middles_s(self, stamp_after_middle: float) -> NDArray[np.float64]:
        return np.array([s.stamp_s - stamp_after_middle * s.exposure_ms * 1e-3 for s in self.shots])

    def stamp_after_middle(self) -> float:
        """Place of the stamps in the exposure: 0 in the middle, 0.5 at the end, -0.5 at the start.

        With the right one the velocity of the image is steadiest over exposures of different length; shots of
        one length do not tell, and their stamps are taken to be of the middle.
        """
        if len({shot.exposure_ms for shot in self.shots}) < 2 or len(self.shots) < 6:
            return 0.0
        coarse = np.stack([[tile.mean((0, 1)) for tile in _tiles(moved)] for moved in self.moved_px])

        def jerk(place: float) -> float:
            duration_s = np.diff(self._middles_s(place))
            if np.any(duration_s <= 0):
                return np.inf
            velocity = coarse / duration_s[:, None, None]
            return float(np.sum(np.diff(velocity, 2, axis=0) ** 2) / np.sum(velocity**2))

        return min((-0.5, 0.0, 0.5), key=jerk)


def _tiles(moved_px: NDArray[np.float32]) -> list[NDArray[np.float32]]:
    height, width = moved_px.shape[:2]
    rows, columns = (np.linspace(0, size, 5).astype(int) for size in (height, width))
    return [moved_px[a:b, c:d] for a, b in pairwise(rows) for c, d in pairwise(columns)]


def shot_of(
    light_dn: NDArray[np.float32], *, stamp_s: float, exposure_ms: float, white_per_ms: float
) -> Shot:
    """A frame of (H, W) light, brought to the same brightness whatever its exposure.

    `white_per_ms`: light per millisecond that becomes white [DN/ms].
    """
    height, width = (size // 2 for size in light_dn.shape)
    pairs = light_dn[: 2 * height, : 2 * width].reshape(height, 2, width, 2).mean((1, 3))
    even = cv2.GaussianBlur(pairs / np.float32(exposure_ms), (0, 0), 1.2)
    grey = 255 * np.sqrt(np.clip(even / np.float32(white_per_ms), 0, 1))
    return Shot(stamp_s, exposure_ms, grey.astype(np.uint8))


def shots_of(recording: Recording, light: Mapping[str, NDArray[np.float32]]) -> dict[str, list[Shot]]:
    """Every frame of a recording, ready for motion, by exposure. `light`: (N, H, W) of each exposure [DN]."""
    exposures = recording.exposures
    bright = [
        np.quantile(each[:, ::4, ::4], 0.95) / exposures[name].exposure_ms for name, each in light.items()
    ]
    white_per_ms = float(np.median(bright))
    return {
        name: [
            shot_of(frame, stamp_s=float(stamp_s), exposure_ms=frames.exposure_ms, white_per_ms=white_per_ms)
            for frame, stamp_s in zip(light[name], frames.stamp_s, strict=True)
        ]
        for name, frames in exposures.items()
    }


def steps_between(shots: Sequence[Shot]) -> Steps:
    """Dense flow between consecutive shots, by time.

    Source: Kroeger et al. 2016, "Fast optical flow using dense inverse search".
    """
    ordered = sorted(shots, key=lambda shot: shot.stamp_s)
    finder = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    moved = []
    for first, second in pairwise(ordered):
        flow = 2 * np.asarray(finder.calc(first.grey, second.grey, None), np.float32)  # type: ignore[call-overload]
        clean = [cv2.medianBlur(np.ascontiguousarray(flow[..., axis]), 5) for axis in (0, 1)]
        moved.append(cv2.GaussianBlur(np.stack(clean, -1), (0, 0), _SMOOTHED_PX / 2))
    return Steps(ordered, np.stack(moved).astype(np.float32))


def blurred(
    light_dn: NDArray[np.float32],
    motion: Motion,
    *,
    middle_s: float,
    own_ms: float,
    wanted_ms: float,
    mosaic: int,
) -> NDArray[np.float32]:
    """Light averaged over a longer exposure than its own.

    Copies, each a whole exposure of its own, are moved along the motion and averaged: together they tile the
    longer exposure. Every pixel has its own path, so turning and approach blur it as they do in a camera.

    - `light_dn`: (H, W) light of one frame [DN].
    - `middle_s`: middle of the longer exposure [s].
    - `own_ms`, `wanted_ms`: exposure of the frame, and the one to reach [ms].
    - `mosaic`: period of the colour filters [px]: 2 for Bayer, 1 for none; each colour is moved by itself.
    """
    copies = max(2, int(np.ceil(wanted_ms / own_ms - 1e-9)))
    offsets_s = (np.arange(copies) / (copies - 1) - 0.5) * (wanted_ms - own_ms) * 1e-3
    result = np.zeros_like(light_dn)
    height, width = light_dn.shape
    for offset_s in offsets_s:
        coarse = motion.at(middle_s + offset_s / 2) * np.float32(offset_s)
        moved = cv2.resize(coarse, (-(-width // mosaic), -(-height // mosaic))) / np.float32(mosaic)
        for row in range(mosaic):
            for column in range(mosaic):
                plane = np.ascontiguousarray(light_dn[row::mosaic, column::mosaic])
                own = moved[: plane.shape[0], : plane.shape[1]]
                y, x = np.mgrid[: plane.shape[0], : plane.shape[1]].astype(np.float32)
                there = cv2.remap(
                    plane, x - own[..., 0], y - own[..., 1], cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE
                )
                result[row::mosaic, column::mosaic] += there / np.float32(copies)
    return result
