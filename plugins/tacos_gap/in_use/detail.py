"""Fine detail of a frame beside that of a shorter exposure of the same moment, tile by tile."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_worlds.recorded.motion import Motion, blurred
from tacos_worlds.recorded.noise import LinearNoise
from tacos_worlds.recorded.source import Source

_TILE_PX = 24
_SMOOTHED_PX = 1.0
"""Detail is taken at this scale, where frames still have more of it than noise [px of a colour's plane]."""
_UNCLIPPED = 0.8
"""Share of the light at which samples are clipped up to which no tile is near that."""
_DETAIL_OVER_NOISE = 2.0
_FEWEST_TILES = 8
_OF_MEDIAN = 1.2533
"""Standard error of a median over that of a mean."""

Plane = NDArray[np.float32]


@dataclass(frozen=True)
class Detail:
    seen: float  # logarithm of its detail over that of the shorter exposure, the median of tiles [1]
    error: float  # standard error of that [1]
    of_path: float  # the same, as blur along the path of each pixel makes it [1]
    path_px: float


def detail_of(source: Source, motion: Motion, name: str, index: int, reference: str) -> Detail | None:
    """Detail of a frame beside the frame of a shorter exposure that is nearest in time.

    The shorter frame is brought to the moment of the longer one by the motion, so that tiles show the same.

    Returns None where too few tiles have detail above the noise and below clipping.
    """
    frames, shorter = source.recording.exposures[name], source.recording.exposures[reference]
    ratio = np.float32(frames.exposure_ms / shorter.exposure_ms)
    middle_s = source.middle_s(name, index)
    others_s = np.array([source.middle_s(reference, i) for i in range(len(shorter.stamp_s))])
    nearest = int(np.argmin(np.abs(others_s - middle_s)))
    sharp = source.samples(reference, nearest)
    path = {"own_ms": shorter.exposure_ms, "wanted_ms": frames.exposure_ms, "mosaic": source.mosaic}
    smeared = blurred(sharp, motion, middle_s=middle_s, **path)  # type: ignore[arg-type]
    apart_s = np.float32(middle_s - others_s[nearest])
    moved_px = motion.at((middle_s + others_s[nearest]) / 2) * apart_s / np.float32(source.mosaic)
    own, theirs = (_as_steps(source.noise(each)) for each in (name, reference))
    unclipped_dn = np.float32(_UNCLIPPED * (source.recording.clipping_dn - source.black_dn))
    seen, made = list[float](), list[float]()
    for row, column in source.greens:
        step = source.mosaic
        frame = source.samples(name, index)[row::step, column::step]
        expected = _moved(sharp[row::step, column::step], moved_px) * ratio
        along_path = _moved(smeared[row::step, column::step], moved_px) * ratio
        noise = own(frame, np.float32(1))
        noise_there = theirs(expected, ratio)
        brightest = cv2.dilate(np.maximum(frame, expected), np.ones((7, 7)))[:-1, :-1]
        below = _tiles((brightest > unclipped_dn).astype(np.float32)) < 0.02
        here = _tiles(_steps(frame) - noise)
        there = _tiles(_steps(expected) - noise_there)
        known = below & (here > 0) & (there > _DETAIL_OVER_NOISE * _tiles(noise_there))
        seen += list(0.5 * np.log(here[known] / there[known]))
        made += list(0.5 * np.log(_tiles(_steps(along_path))[known] / _tiles(_steps(expected))[known]))
    if len(seen) < _FEWEST_TILES:
        return None
    speed = float(np.median(np.linalg.norm(motion.at(middle_s), axis=-1)))
    error = _OF_MEDIAN * float(np.std(seen)) / len(seen) ** 0.5
    return Detail(float(np.median(seen)), error, float(np.median(made)), speed * frames.exposure_ms * 1e-3)


def _steps(plane: Plane) -> Plane:
    """Squared steps to the right and down of a smoothed (H, W) plane, (H - 1, W - 1)."""
    smooth = cv2.GaussianBlur(plane, (0, 0), _SMOOTHED_PX)
    right, down = smooth[:-1, 1:] - smooth[:-1, :-1], smooth[1:, :-1] - smooth[:-1, :-1]
    return np.asarray(right**2 + down**2, np.float32)


def _noise_in_steps() -> np.float32:
    one = np.zeros((33, 33), np.float32)
    one[16, 16] = 1
    return np.float32(_steps(one).sum())


def _as_steps(noise: LinearNoise) -> Callable[[Plane, np.float32], Plane]:
    """Squared steps of the noise of a plane whose samples were multiplied by a factor."""
    per_variance = _noise_in_steps()

    def steps(plane: Plane, factor: np.float32) -> Plane:
        variance = factor * (noise.floor_dn2 * factor + noise.slope_dn * np.maximum(plane, 0))
        return np.asarray(per_variance * variance[:-1, :-1], np.float32)

    return steps


def _tiles(values: Plane) -> Plane:
    rows, columns = values.shape[0] // _TILE_PX, values.shape[1] // _TILE_PX
    cut = values[: rows * _TILE_PX, : columns * _TILE_PX]
    return np.asarray(cut.reshape(rows, _TILE_PX, columns, _TILE_PX).mean((1, 3)), np.float32)


def _moved(plane: Plane, moved_px: NDArray[np.float32]) -> Plane:
    """A plane moved by a displacement at other resolution, in pixels of the plane."""
    height, width = plane.shape
    step = cv2.resize(moved_px, (width, height))
    y, x = np.mgrid[:height, :width].astype(np.float32)
    there = cv2.remap(
        plane, x - step[..., 0], y - step[..., 1], cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE
    )
    return np.asarray(there, np.float32)
