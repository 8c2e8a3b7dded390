"""Share of the motion of the image in the blur of an exposure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import norm
from scipy.stats import t as student

from tacos_gap.in_use.detail import Detail

REST_PX = 1.0
"""The image is at rest where the usual pixel moves less during the longest exposure [px]."""
_TOLD = 0.01
"""Detail that blur along the path has to cost before frames can tell of it [1]."""
_LITTLE = 0.05
"""Detail that may come and go at rest without a name [1]."""
_FEWEST = 4


@dataclass(frozen=True)
class MotionBlur:
    """Blur of an exposure, in shares of what the path of each pixel makes."""

    exposure_ms: float
    frames_at_rest: int
    frames_moving: int
    share: float | None
    """1 where an exposure is blurred as its motion says, 0 where not at all; None where frames cannot
    tell."""
    interval: tuple[float, float] | None  # 95 % of the share [1]
    path_px: float  # path of the usual pixel in the frames in motion, on average [px]
    rest: tuple[float, float] | None
    """Largest departure of a frame at rest from the others at rest, in its detail, and what scatter of tiles
    keeps it within in 19 of 20 recordings [1]."""

    @property
    def present(self) -> bool:
        return self.interval is not None and self.interval[0] > 0


def motion_blur(exposure_ms: float, longest_ms: float, details: Sequence[Detail]) -> MotionBlur:
    """The line through what frames show over what their path makes: its slope is the share.

    Its offset, which frames at rest have as well, is left free: noise changes the detail of all alike.
    """
    resting = [d for d in details if d.path_px * longest_ms / exposure_ms < REST_PX]
    moving = [d for d in details if d not in resting]
    path_px = float(np.mean([d.path_px for d in moving])) if moving else 0.0
    of_path = np.array([d.of_path for d in details])
    share = interval = None
    if len(details) >= _FEWEST and moving and -of_path.min() > _TOLD:
        matrix = np.stack([np.ones(len(details)), of_path], axis=1)
        seen = np.array([d.seen for d in details])
        (offset, slope), *_ = np.linalg.lstsq(matrix, seen, rcond=None)
        free = len(details) - 2
        variance = float(np.sum((seen - offset - slope * of_path) ** 2)) / free
        half = float(student.ppf(0.975, free) * np.sqrt(variance * np.linalg.inv(matrix.T @ matrix)[1, 1]))
        share, interval = float(slope), (float(slope) - half, float(slope) + half)
    rest = None
    if len(resting) > 2:
        at_rest = np.array([d.seen for d in resting])
        error = float(np.sqrt(np.mean([d.error**2 for d in resting])))
        limit = max(_LITTLE, float(norm.ppf(1 - 0.025 / len(resting))) * error)
        rest = (float(np.abs(at_rest - np.median(at_rest)).max()), limit)
    return MotionBlur(exposure_ms, len(resting), len(moving), share, interval, path_px, rest)
