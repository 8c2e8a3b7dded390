"""Replayed exposures beside real ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_validation.exposures_replayed.emulation import Lack
from tacos_validation.rank_agreement.agreement import tau_b

TOLERANCE = 0.15
LEAST_TOLERANCE = 10.0
"""A replay is to be within 15 %, or ten inliers, of reality."""

REASONS: Mapping[Lack, str] = {
    "noise": "the source is noisier than this exposure, and its noise decides",
    "blur": "the source is blurred by more motion than this exposure, and its blur decides",
    "highlights": "highlights are clipped or uncertain in the source alone, and they decide",
    "shadows": "shadows are cut off in the source and not in this exposure, and they decide",
}
TOO_FEW_FOR_BLUR = (
    "the source is blurred by more motion than this exposure, and too few inliers are left to show what that "
    "costs"
)
_SHARP_PX = 1.0
"""Blur of the source that costs a shorter exposure nothing [px]."""
OTHER_MOMENTS = "the frames of the source were taken at other moments: fewer than two lie beside these"


@dataclass(frozen=True)
class ReplayedExposure:
    """Inliers of one exposure, in reality and as replayed; `refused` says why there is no replay.

    ``real`` is None where it was not measured.
    """

    ms: float
    real: float | None
    predicted: float | None
    interval: tuple[float, float] | None
    refused: str | None

    @property
    def near(self) -> bool | None:
        """True within the tolerance; None where it is refused or not measured."""
        if self.predicted is None or self.real is None:
            return None
        return abs(self.predicted - self.real) <= tolerance(self.real)

    def as_data(self) -> dict[str, Any]:
        interval = None if self.interval is None else list(self.interval)
        return {
            "ms": self.ms,
            "real": self.real,
            "predicted": self.predicted,
            "interval": interval,
            "refused": self.refused,
        }


@dataclass(frozen=True)
class SourceFindings:
    """All other exposures, replayed from one."""

    exposures: tuple[ReplayedExposure, ...]

    @property
    def answered(self) -> tuple[ReplayedExposure, ...]:
        return tuple(each for each in self.exposures if each.predicted is not None)

    @property
    def tau(self) -> float | None:
        """Kendall's tau-b over those that are measured and not refused; None for fewer than two."""
        pairs = [(each.real, each.predicted) for each in self.answered if each.real is not None]
        return tau_b(*map(list, zip(*pairs, strict=True))) if len(pairs) > 1 else None


def tolerance(inliers: float) -> float:
    return max(TOLERANCE * inliers, LEAST_TOLERANCE)


def replayed(
    ms: float,
    real: float | None,
    pairs: NDArray[np.float64],
    worse: Mapping[Lack, float],
    *,
    ratio: float,
    blur_px: float,
) -> ReplayedExposure:
    """An exposure from the inliers of its replayed pairs.

    Its interval holds the scatter of neighbouring pairs, and what it changed to double what the source
    lacks; where all lacks together change more than the tolerance the exposure is refused. So it is where a
    source that is blurred leaves next to nothing, which no further blur can change.

    Where few inliers are left noise has taken most of them, and once more takes little: then its change
    counts for each doubling between the two exposures.

    - `ratio`: this exposure over that of the source [1].
    - `blur_px`: of the source.
    """
    predicted = float(pairs.mean())
    if "blur" in worse and blur_px > _SHARP_PX and predicted < LEAST_TOLERANCE:
        return ReplayedExposure(ms, real, None, None, TOO_FEW_FOR_BLUR)
    changes = {name: abs(value - predicted) for name, value in worse.items()}
    if "noise" in changes and predicted < LEAST_TOLERANCE / TOLERANCE:
        changes["noise"] *= float(np.log2(ratio))
    if sum(changes.values()) > tolerance(predicted):
        name = max(changes, key=changes.__getitem__)
        change = abs(worse[name] - predicted)
        reason = f"{REASONS[name]}: the same once more changes {predicted:.0f} inliers by {change:.0f}"
        return ReplayedExposure(ms, real, None, None, reason)
    scatter = float(
        np.sqrt(max(predicted, 1.0) / len(pairs))
    )  # of counts, where pairs are too few to tell it
    if len(pairs) > 2:
        scatter = float(np.std(np.diff(pairs)) / np.sqrt(2 * len(pairs)))
    half = float(np.sqrt((1.96 * scatter) ** 2 + sum(change**2 for change in changes.values())))
    return ReplayedExposure(ms, real, predicted, (max(predicted - half, 0.0), predicted + half), None)
