"""A path on the floor and the doorways it crosses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

STEP_M = 0.05
"""Distance between points of a path [m]."""


@dataclass(frozen=True, eq=False)
class Route:
    points_m: NDArray[np.float64]  # (N, 2) points, about `STEP_M` apart [m]
    door_at: tuple[tuple[int, int], ...]
    """For each doorway crossed, in order: (index of the path's point on its middle, index of the door)."""
