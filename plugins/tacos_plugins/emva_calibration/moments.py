"""Means and variances of groups of frames, taken one frame after another.

Variance over time is that of the difference of two frames (EMVA 1288, Release 4.0 Linear, Sec. 6.2), which
knows no fixed pattern. The difference is taken apart further: means of its rows and columns, in which a lamp
that flickers shows, are kept beside the variance of what they leave over.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Frame = Sequence[NDArray[np.integer]]
"""(H, W) arrays of one frame: the planes of a channel, two for the green of a mosaic [DN]."""


@dataclass(frozen=True)
class Moments:
    """Moments of one channel of a group of frames."""

    frames: int
    pixels: int
    """Number of frames; pixels of one frame."""
    mean_dn: float
    """Mean of all frames [DN]."""
    variance_dn2: float
    variance_error_dn2: float
    """Variance over time within rows and columns, and its standard error [DN^2]."""
    bands_dn2: float
    bands_error_dn2: float
    """Variance over time that whole rows and columns share, its expectation by chance taken off; and the
    scatter that chance gives it [DN^2].
    """
    drift_dn: float
    spread_dn: float
    """Root mean square of the difference of means of two frames in succession; and the brightest mean less
    the dimmest [DN].
    """
    neighbours: float
    """Correlation of the noise of neighbouring pixels, the larger of that in rows and in columns [1]."""
    lowest_dn: float
    highest_dn: float
    """Smallest and largest sample [DN]."""
    at_zero: float
    at_highest: float
    """Share of samples that are 0, and that equal the largest [1]."""
    bits: int
    """All samples joined by a bitwise or."""

    def scaled(self, step_dn: int) -> Moments:
        """The same in steps of so many digital numbers."""
        one, two = 1 / step_dn, 1 / step_dn**2
        return Moments(
            self.frames, self.pixels, self.mean_dn * one, self.variance_dn2 * two,
            self.variance_error_dn2 * two, self.bands_dn2 * two, self.bands_error_dn2 * two,
            self.drift_dn * one, self.spread_dn * one, self.neighbours,
            self.lowest_dn * one, self.highest_dn * one, self.at_zero, self.at_highest, self.bits // step_dn,
        )  # fmt: skip


@dataclass(frozen=True)
class Difference:
    """Half the variance of the difference of two frames, taken apart; see `Moments`."""

    variance_dn2: float
    error_dn2: float
    bands_dn2: float
    bands_error_dn2: float
    mean_dn: float
    neighbours: tuple[float, float]


def difference(first: NDArray[np.integer], second: NDArray[np.integer]) -> Difference:
    """Variance over time from two frames (H, W) of the same light."""
    step = first.astype(np.float32) - second.astype(np.float32)
    height, width = step.shape
    mean = float(step.mean(dtype=np.float64))
    rows = step.mean(axis=1, keepdims=True, dtype=np.float64) - mean
    columns = step.mean(axis=0, keepdims=True, dtype=np.float64) - mean
    rest = step - (rows + columns + mean).astype(np.float32)
    squares = rest.astype(np.float64) ** 2
    freedom = max((height - 1) * (width - 1), 1)
    variance = float(squares.sum()) / freedom
    spread = float((squares**2).mean()) - float(squares.mean()) ** 2
    by_chance = variance * (1 / width + 1 / height)
    bands = float(rows.var(ddof=1) + columns.var(ddof=1)) if min(height, width) > 1 else 0.0
    scatter = variance * np.sqrt(2 / max(height - 1, 1) / width**2 + 2 / max(width - 1, 1) / height**2)
    power = max(float(squares.mean()), 1e-30)
    beside = float((rest[:, 1:] * rest[:, :-1]).mean()), float((rest[1:] * rest[:-1]).mean())
    return Difference(
        variance / 2, np.sqrt(max(spread, 0.0) / freedom) / 2, (bands - by_chance) / 2, scatter / 2, mean,
        (beside[0] / power, beside[1] / power),
    )  # fmt: skip


def moments_of(frames: Iterable[Frame]) -> Moments:
    """Moments of a group of at least two frames; pairs are the first and second, third and fourth, ...

    Raises `ValueError` when there are fewer than two.
    """
    found: list[Difference] = []
    means: list[float] = []
    lowest, highest, zeros, at_highest, bits, samples = np.inf, -1.0, 0, 0, 0, 0
    before: Frame | None = None
    for frame in frames:
        for plane in frame:
            top = float(plane.max())
            at_top = int((plane == top).sum())
            at_highest = at_top if top > highest else at_highest + at_top * (top == highest)
            highest, lowest = max(highest, top), min(lowest, float(plane.min()))
            zeros += int((plane == 0).sum())
            bits |= int(np.bitwise_or.reduce(plane, axis=None))
            samples += plane.size
        means.append(float(np.mean([plane.mean(dtype=np.float64) for plane in frame])))
        if before is not None:
            found += [difference(one, two) for one, two in zip(before, frame, strict=True)]
        before = None if before is not None else frame
    if not found:
        raise ValueError("variance over time takes at least two frames")
    several = np.sqrt(len(found))
    return Moments(
        frames=len(means),
        pixels=samples // len(means),
        mean_dn=float(np.mean(means)),
        variance_dn2=float(np.mean([each.variance_dn2 for each in found])),
        variance_error_dn2=float(np.sqrt(np.mean([each.error_dn2**2 for each in found])) / several),
        bands_dn2=float(np.mean([each.bands_dn2 for each in found])),
        bands_error_dn2=float(np.sqrt(np.mean([each.bands_error_dn2**2 for each in found])) / several),
        drift_dn=float(np.sqrt(np.mean(np.diff(means) ** 2))),
        spread_dn=float(np.ptp(means)),
        neighbours=float(max(np.mean([each.neighbours for each in found], axis=0), key=abs)),
        lowest_dn=float(lowest),
        highest_dn=highest,
        at_zero=zeros / samples,
        at_highest=at_highest / samples,
        bits=bits,
    )
