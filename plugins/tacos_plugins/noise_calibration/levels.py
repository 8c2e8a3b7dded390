"""Measuring noise: variance over time and mean of one static scene, level of brightness by level.

Variance is taken over time, pixel by pixel, from differences of consecutive frames, so that what is fixed to
the sensor or the scene (pixels of unequal response, uneven light) does not count as noise, and neither does
light that drifts slowly or flickers as a whole. Pixels are then gathered in levels of equal mean.

Source: EMVA Standard 1288, Release 4.0, Sec. 6 (difference of two frames); von Neumann 1941, "Distribution of
the ratio of the mean square successive difference to the variance".
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, stats

_LEAST_PIXELS = 100
REACH_PX = 4
"""Pixels so near to where brightness changes are left out [px]."""
_OUTLIER_PROBABILITY = 1e-7


@dataclass(frozen=True, eq=False)
class Levels:
    """Measurements of one channel, level by level, from dark to bright."""

    mean_dn: NDArray[np.float64]
    """(L,) mean, pedestal included [DN]."""
    variance_dn2: NDArray[np.float64]
    """(L,) variance over time, rounding included [DN^2]."""
    error_dn2: NDArray[np.float64]
    """(L,) its standard error [DN^2]."""
    fixed_dn2: NDArray[np.float64]
    """(L,) variance from pixel to pixel that stays from frame to frame [DN^2]."""
    pixels: NDArray[np.int64]
    """(L,) pixels in the level."""
    clipped: NDArray[np.float64]
    """(L,) share of samples at 0 or at the white level [1]."""
    edge_excess: float
    """Variance over time where brightness changes, over that of even parts; far above 1 for what moves
    [1].
    """
    outliers: int
    """Pixels left out because they jump: their variance is far beyond chance."""
    frames: int


def measure_levels(
    planes: Sequence[NDArray[np.uint8] | NDArray[np.uint16]], *, white_level_dn: float, levels: int = 64
) -> Levels:
    """Mean and variance over time of one channel.

    - `planes`: arrays (F, H, W) of the same F >= 2 frames; more than one where a mosaic holds a colour twice
      [DN].
    - `white_level_dn`: full scale [DN].
    - `levels`: into how many steps the range of means is cut; those of too few pixels are left out.

    Raises `ValueError` when there are fewer than two frames.
    """
    frames = len(planes[0])
    if frames < 2:
        raise ValueError(f"variance over time takes at least two frames, not {frames}")
    stacks = [_Stack.of(plane, white_level_dn) for plane in planes]
    means = np.concatenate([stack.smooth[stack.even] for stack in stacks])
    if means.size == 0:
        means = np.concatenate([stack.smooth.ravel() for stack in stacks])
    edges = np.linspace(means.min(), means.max() + 1e-6, levels + 1)
    gathered = [stack.gathered(edges) for stack in stacks]
    pixels, mean, variance, fixed_sum, pairs, clipped, outliers, edge, expected = (
        sum(part) for part in zip(*gathered, strict=True)
    )
    kept = pixels >= _LEAST_PIXELS
    with np.errstate(invalid="ignore", divide="ignore"):
        variance_dn2 = (variance / pixels)[kept]
        fixed_dn2 = np.maximum((fixed_sum / pairs)[kept] - variance_dn2 / frames, 0.0)
        clipped_share = (clipped / pixels)[kept] / frames
        mean_dn = (mean / pixels)[kept]
    return Levels(
        mean_dn=mean_dn,
        variance_dn2=variance_dn2,
        error_dn2=variance_dn2 * np.sqrt(_relative_variance(frames) / pixels[kept]),
        fixed_dn2=np.nan_to_num(fixed_dn2),
        pixels=pixels[kept].astype(np.int64),
        clipped=clipped_share,
        edge_excess=float(edge / expected) if expected > 0 else 1.0,
        outliers=int(outliers),
        frames=frames,
    )


def _relative_variance(frames: int) -> float:
    """Variance of half the mean square successive difference of a pixel, for Gaussian noise of variance 1."""
    return (3 * frames - 4) / (frames - 1) ** 2


@dataclass(frozen=True, eq=False)
class _Stack:
    """Frames of one plane, their mean, the pixels of even brightness, and counts of censored samples.

    Pixels are sorted into levels by the mean of their neighbourhood: a pixel's own mean carries its noise,
    and levels sorted by it would spread farther than the signal does, which makes the line too flat.
    """

    frames: NDArray[np.uint8] | NDArray[np.uint16]
    mean: NDArray[np.float32]
    smooth: NDArray[np.float32]
    even: NDArray[np.bool_]
    clipped: NDArray[np.float32]

    @classmethod
    def of(cls, frames: NDArray[np.uint8] | NDArray[np.uint16], white_level_dn: float) -> _Stack:
        mean = frames.mean(axis=0, dtype=np.float32)
        clipped = np.zeros(mean.shape, np.float32)
        for frame in frames:
            clipped += (frame == 0) | (frame >= white_level_dn)
        smooth = ndimage.uniform_filter(mean, 5)
        return cls(frames, mean, smooth, _even(frames, smooth), clipped)

    def gathered(self, edges: NDArray[np.float64]) -> tuple[NDArray[np.float64] | float, ...]:
        """Sums over the pixels of each level; see `measure_levels`."""
        count = len(edges) - 1
        level = np.clip(np.digitize(self.smooth, edges) - 1, 0, count - 1)
        variance = self._over_time(level, count)
        at = level[self.even]
        typical = _per_level(at, variance[self.even], count) / np.maximum(_per_level(at, None, count), 1)
        freedom = 2 / _relative_variance(len(self.frames))
        most = stats.chi2.isf(_OUTLIER_PROBABILITY, freedom) / freedom
        steady = self.even & (variance <= np.maximum(most * typical[level], 1.0))
        at = level[steady]
        neighbours = steady[:, 1:] & steady[:, :-1]
        steps = np.diff(self.mean, axis=1)[neighbours] ** 2 / 2
        uneven = ~self.even & (self.clipped == 0)
        return (
            _per_level(at, None, count),
            _per_level(at, self.mean[steady], count),
            _per_level(at, variance[steady], count),
            _per_level(level[:, 1:][neighbours], steps, count),
            _per_level(level[:, 1:][neighbours], None, count),
            _per_level(at, self.clipped[steady], count),
            float((self.even & ~steady).sum()),
            float(variance[uneven].sum()),
            float(typical[np.clip(np.digitize(self.mean[uneven], edges) - 1, 0, count - 1)].sum()),
        )

    def _over_time(self, level: NDArray[np.intp], count: int) -> NDArray[np.float32]:
        """Half the mean square of successive differences, each taken about its mean over the level."""
        total = np.zeros(self.mean.shape, np.float32)
        of_level = np.maximum(_per_level(level[self.even], None, count), 1)
        for before, after in zip(self.frames[:-1], self.frames[1:], strict=True):
            step = after.astype(np.float32) - before
            shift = _per_level(level[self.even], step[self.even], count) / of_level
            total += (step - shift.astype(np.float32)[level]) ** 2
        estimated = of_level / np.maximum(of_level - 1, 1)  # a mean was taken off each level
        total *= estimated.astype(np.float32)[level] / np.float32(2 * (len(self.frames) - 1))
        return total


def _per_level(
    level: NDArray[np.intp], values: NDArray[np.floating] | None, count: int
) -> NDArray[np.float64]:
    return np.bincount(level.ravel(), None if values is None else values.ravel(), count).astype(np.float64)


def _even(frames: NDArray[np.uint8] | NDArray[np.uint16], smooth: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Pixels around which brightness hardly changes: away from bar edges, within what noise leaves open."""
    step = frames[1].astype(np.float32) - frames[0]
    noise = np.sqrt(ndimage.uniform_filter(step**2, 15) / 2)
    allowed = 6 * noise * math.sqrt(2 / (25 * len(frames))) + 0.01 * np.ptp(
        np.percentile(smooth, (0.5, 99.5))
    )
    even = np.zeros(smooth.shape, bool)
    inner = np.s_[REACH_PX:-REACH_PX, REACH_PX:-REACH_PX]
    across = np.abs(smooth[:, 2 * REACH_PX :] - smooth[:, : -2 * REACH_PX])[REACH_PX:-REACH_PX]
    along = np.abs(smooth[2 * REACH_PX :] - smooth[: -2 * REACH_PX])[:, REACH_PX:-REACH_PX]
    even[inner] = np.maximum(across, along) <= allowed[inner]
    return even
