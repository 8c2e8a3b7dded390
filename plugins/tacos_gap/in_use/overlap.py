"""The same points in consecutive frames: brightness that is not steady, and corners that are darker."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from tacos_worlds.recorded.source import Source

_TILE = 16
"""Side of a tile in which the median is taken [2 px]."""
_DIM, _UNCLIPPED = 0.003, 0.8
"""Shares of the light at which samples are clipped, between which light is compared [1]."""
_TEXTURED = 16.0
"""Least eigenvalue of the gradients around a point from which flow finds where it went: noise of 8 bits makes
one or two, a camera that is followed across a blank wall seems to have no fall-off [squared grey/px]."""
_FEWEST_TILES, _FEWEST_STEPS, _FEWEST_IN_ROW = 12, 4, 4
_OF_MEDIAN = 1.2533
"""Standard error of a median over that of a mean."""
_SHAPE_ERROR = 0.04
"""Half an interval of vignetting at least: lenses of cos^4 or r^4 with 40 % of the light in the corner are
read as 44 and 40 % [1]."""
_LARGEST_ERROR = 0.5
"""Half of the interval of vignetting from which the frames tell nothing of it [1]."""
_STEADY, _CLEAR_Z = 0.03, 5.0
"""Changes of brightness have no name up to this share, or so many standard errors [1]."""
_FAINT = 0.05
"""Vignetting has no name up to this share [1]."""

Plane = NDArray[np.float32]
Values = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Overlap:
    """Tiles that two consecutive frames show; (T,) each."""

    names: tuple[str, str]  # of their exposures
    ratio: Values  # logarithm of light of the later frame over the earlier one's [1]
    radius2: tuple[Values, Values]  # squared radius in the earlier and the later frame, 1 in the corner [1]
    row: NDArray[np.int64]  # of tiles, from the top [1]
    textured: NDArray[np.bool_]  # true where the flow has something to follow


@dataclass(frozen=True)
class Vignetting:
    """Light that corners lack beside the centre [1]; None where the image does not move enough to tell."""

    corner: float | None
    interval: tuple[float, float] | None  # 95 %

    @property
    def present(self) -> bool:
        return self.interval is not None and self.interval[0] > _FAINT


@dataclass(frozen=True)
class Steadiness:
    """Brightness of the same points from frame to frame, beyond what exposure times make."""

    largest: float  # change of a whole frame to the next, as a share [1]
    bands: float  # standard deviation over rows of such a change, as a share [1]
    limits: tuple[float, float]  # up to which the two have no name [1]
    settles: bool  # true if changes come in the first half alone and go one way

    @property
    def cause(self) -> str | None:
        whole, bands = self.largest > self.limits[0], self.bands > self.limits[1]
        if not whole and not bands:
            return None
        return "settling exposure" if self.settles and not bands else "flicker"


def overlaps(source: Source) -> list[Overlap]:
    """Tiles of each frame beside the next one, brought to the same place by the flow between them."""
    if source.steps is None:
        return []
    frames = sorted(
        (
            (stamp_s, name, index)
            for name, each in source.recording.exposures.items()
            for index, stamp_s in enumerate(each.stamp_s)
        ),
        key=lambda frame: frame[0],
    )
    planes = pairwise(_light_per_ms(source, name, index) for _, name, index in frames)
    names = pairwise(name for _, name, _ in frames)
    shots, moved_px = source.steps.shots, source.steps.moved_px
    found = (
        _overlap(pair, *both, moved, _textured(shot.grey))
        for pair, both, moved, shot in zip(names, planes, moved_px, shots[:-1], strict=True)
    )
    return [each for each in found if len(each.ratio) >= _FEWEST_TILES]


def vignetting(found: Sequence[Overlap]) -> Vignetting:
    """The fall-off 1 + k r^2 that makes the same points equally bright wherever the image has them.

    The error is that over steps between frames, whose flow is wrong as a whole where it is.
    """
    found = [_where(each, each.textured) for each in found if each.textured.sum() >= _FEWEST_TILES]
    if len(found) < _FEWEST_STEPS:
        return Vignetting(None, None)
    k = 0.0
    for _ in range(8):  # Gauss-Newton
        slopes = [_slopes(each, k) for each in found]
        rests = [_centred(each.ratio - _fall_off(each, k)) for each in found]
        size = sum(float(x @ x) for x in slopes)
        moved = sum(float(x @ y) for x, y in zip(slopes, rests, strict=True)) / size if size else np.inf
        k = float(np.clip(k + moved, -0.95, 5.0))
    error = (
        sum(float(x @ y) ** 2 for x, y in zip(slopes, rests, strict=True)) ** 0.5 / size if size else np.inf
    )
    half = float(np.hypot(student.ppf(0.975, len(found) - 1) * error, _SHAPE_ERROR))
    if half >= _LARGEST_ERROR:
        return Vignetting(None, None)
    return Vignetting(-k, (-k - half, min(-k + half, 1.0)))


def steadiness(found: Sequence[Overlap], vignetting: Vignetting) -> Steadiness | None:
    """Changes of brightness that exposure times do not explain; None where too few frames overlap.

    All steps between the same two exposures share the error of the response. It is taken off, from the later
    half of the steps: by then a camera has found its exposure. So is vignetting that was found: what moves
    into a corner dims without a lamp.
    """
    if len(found) < _FEWEST_STEPS:
        return None
    if vignetting.present and vignetting.corner is not None:
        k = -vignetting.corner
        found = [replace(each, ratio=each.ratio - _fall_off(each, k)) for each in found]
    steps = np.array([np.median(each.ratio) for each in found])
    for names in {each.names for each in found}:
        alike = [k for k, each in enumerate(found) if each.names == names]
        steps[alike] -= np.median(steps[alike[len(alike) // 2 :]])
    whole = [
        (abs(float(step)), _limit(each.ratio, len(each.ratio)))
        for step, each in zip(steps, found, strict=True)
    ]
    named = [k for k, (step, limit) in enumerate(whole) if step > limit]
    one_way = abs(sum(np.sign(steps[k]) for k in named)) == len(named)
    largest, banded = (
        max(each, key=lambda pair: pair[0] / pair[1]) for each in (whole, list(map(_bands, found)))
    )
    settles = bool(named and one_way and named[-1] < len(found) / 2)
    return Steadiness(largest[0], banded[0], (largest[1], banded[1]), settles)


def _bands(overlap: Overlap) -> tuple[float, float]:
    """Standard deviation over rows of the change of brightness, and up to which it has no name [1]."""
    rows = [overlap.ratio[overlap.row == row] for row in np.unique(overlap.row)]
    rows = [own for own in rows if len(own) >= _FEWEST_IN_ROW]
    if len(rows) < 2:
        return 0.0, _STEADY
    within = np.concatenate([own - np.median(own) for own in rows])
    return float(np.std([np.median(own) for own in rows])), _limit(within, len(within) // len(rows))


def _limit(scattered: Values, count: int) -> float:
    return max(_STEADY, _CLEAR_Z * _OF_MEDIAN * float(np.std(scattered)) / count**0.5)


def _fall_off(overlap: Overlap, k: float) -> Values:
    before, after = overlap.radius2
    return np.asarray(np.log((1 + k * after) / (1 + k * before)))


def _slopes(overlap: Overlap, k: float) -> Values:
    before, after = overlap.radius2
    return _centred(after / (1 + k * after) - before / (1 + k * before))


def _centred(values: Values) -> Values:
    """The rest after what the whole frame has in common: a change of brightness is no fall-off."""
    return np.asarray(values - values.mean())


def _light_per_ms(source: Source, name: str, index: int) -> Plane:
    """(H/2, W/2) light; NaN where it is too dark, or near clipping [DN/ms]."""
    samples = source.samples(name, index)
    height, width = (length // 2 for length in samples.shape)
    four = samples[: 2 * height, : 2 * width].reshape(height, 2, width, 2)
    clipping_dn = np.float32(source.recording.clipping_dn - source.black_dn)
    even = cv2.GaussianBlur(four.mean((1, 3)), (0, 0), 1.2)
    bad = (even < _DIM * clipping_dn) | (
        cv2.dilate(four.max((1, 3)), np.ones((5, 5))) > _UNCLIPPED * clipping_dn
    )
    exposure_ms = np.float32(source.recording.exposures[name].exposure_ms)
    return np.where(bad, np.float32(np.nan), even / exposure_ms)


def _textured(grey: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """(H, W) true where gradients differ in direction, here and around: flow needs it, and is smoothed.

    Source: Shi and Tomasi 1994, "Good features to track".
    """
    found = cv2.cornerMinEigenVal(grey.astype(np.float32), _TILE, ksize=3) > _TEXTURED
    return cv2.erode(found.astype(np.uint8), np.ones((_TILE, _TILE))) > 0


def _where(overlap: Overlap, kept: NDArray[np.bool_]) -> Overlap:
    before, after = overlap.radius2
    return Overlap(
        overlap.names,
        overlap.ratio[kept],
        (before[kept], after[kept]),
        overlap.row[kept],
        overlap.textured[kept],
    )


def _overlap(
    names: tuple[str, str], first: Plane, second: Plane, moved_px: Plane, textured: NDArray[np.bool_]
) -> Overlap:
    height, width = first.shape
    y, x = np.mgrid[:height, :width].astype(np.float32)
    there_x, there_y = x + moved_px[..., 0] / 2, y + moved_px[..., 1] / 2
    nan = float("nan")
    later = cv2.remap(
        second, there_x, there_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=nan
    )
    with np.errstate(invalid="ignore"):
        ratio = np.log(later / first)
    middle = np.array([(width - 1) / 2, (height - 1) / 2], np.float32)
    before, after = (
        _tiles(((px - middle[0]) ** 2 + (py - middle[1]) ** 2) / (middle @ middle)).mean(-1, dtype=np.float64)
        for px, py in ((x, y), (there_x, there_y))
    )
    tiles = _tiles(ratio)
    whole = np.isfinite(tiles).mean(-1) > 0.5
    ratios = np.nanmedian(tiles[whole], axis=-1).astype(np.float64)
    row = np.flatnonzero(whole) // (width // _TILE)
    followed = _tiles(textured.astype(np.float32)).mean(-1) > 0.5
    return Overlap(names, ratios, (before[whole], after[whole]), row, followed[whole])


def _tiles(plane: Plane) -> Plane:
    """(T, samples) of (H, W)."""
    rows, columns = plane.shape[0] // _TILE, plane.shape[1] // _TILE
    cut = plane[: rows * _TILE, : columns * _TILE].reshape(rows, _TILE, columns, _TILE)
    return cut.transpose(0, 2, 1, 3).reshape(-1, _TILE**2)
