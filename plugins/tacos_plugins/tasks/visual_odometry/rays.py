"""Directions as points of a plane, which OpenCV's solvers take."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

PLANE_REACH_DEG = 80.0
"""Rays this far off the axis still meet the plane within six focal lengths [deg]."""


def on_plane(rays: NDArray[np.float64], focal_length_px: float) -> NDArray[np.float64]:
    """(N, 2) points at which rays meet the plane of a pinhole camera without an offset [px]."""
    return np.asarray(focal_length_px * rays[:, :2] / rays[:, 2:])


def reach_plane(rays: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(N,) which of the rays lie within `PLANE_REACH_DEG` of the axis; none that is NaN."""
    return np.asarray(rays[:, 2] > np.cos(np.radians(PLANE_REACH_DEG)))
