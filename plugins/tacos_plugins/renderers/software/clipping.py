"""Triangles that reach behind the camera or far beside the image, cut to what can be drawn.

Source: Sutherland and Hodgman, "Reentrant polygon clipping", CACM 1974.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.compiled.loops import compiled

CORNERS = 9
"""Most corners of a triangle cut by five planes, and one to close it."""

_GUARD_PX = float(1 << 20)
"""Farther out, triangles are cut off, so that edge functions stay exact integers."""


@compiled
def needs_cutting(corners: NDArray[np.float64], near_m: float) -> bool:
    """True if a triangle of homogeneous pixels comes nearer than `near_m` [m], or reaches far beside."""
    for corner in range(3):
        x, y, w = corners[corner, 0], corners[corner, 1], corners[corner, 2]
        if w < near_m or max(abs(x), abs(y)) > _GUARD_PX * w:
            return True
    return False


@compiled
def cut(corners: NDArray[np.float64], spare: NDArray[np.float64], near_m: float) -> int:
    """Cut a triangle at the near plane and far beside the image, in place; how many corners are left.

    Corners are copied number by number, since to compile assignments of slices takes longer than all the
    rest.
    """
    count = 3
    for plane in range(5):
        kept = 0
        for corner in range(count):
            here, before = corners[corner], corners[(corner - 1) % count]
            inside, was_inside = _within(here, plane, near_m), _within(before, plane, near_m)
            if (inside >= 0) != (was_inside >= 0):
                share = was_inside / (was_inside - inside)
                for axis in range(3):
                    spare[kept, axis] = before[axis] + share * (here[axis] - before[axis])
                kept += 1
            if inside >= 0:
                for axis in range(3):
                    spare[kept, axis] = here[axis]
                kept += 1
        count = kept
        for corner in range(count):
            for axis in range(3):
                corners[corner, axis] = spare[corner, axis]
    return count


@compiled
def _within(point: NDArray[np.float64], plane: int, near_m: float) -> float:
    """Positive on the side of a plane that is kept: beyond the near one, within the four beside the image."""
    x, y, w = point[0], point[1], point[2]
    if plane == 0:
        return w - near_m
    along = x if plane < 3 else y
    return _GUARD_PX * w + (along if plane % 2 else -along)
