"""Worlds whose size is that of no building: most likely their unit is another."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.lighting.occlusion import Occlusion

_HIGH_M, _LOW_M = 30.0, 1.6
"""Clear heights of rooms lie between: above is a hangar, below nobody stands upright [m]."""
_TOWERS_M = 100.0
"""Most streets are lower [m]."""
_USUAL_M, _FEET_M = (2.2, 4.5), (7.2, 14.0)
"""Those of most rooms, and what they are in feet [m]."""
_UNITS_M = {
    "inches": 0.0254, "centimetres": 0.01, "millimetres": 0.001, "feet": 0.3048, "kilometres": 1000.0,
    "hundreds of metres": 100.0,
}  # fmt: skip
_LIFT_M = 0.05
_LEAST_UPRIGHT = 0.15
"""Share of a building's surface that is level or along an axis: floors and ceilings alone are a third [1]."""
_MUCH_MORE = 1.5
"""Of area along an axis than along that which a file says is up: it may be the wrong one [1]."""


def doubts_of_height(
    clear_m: float | None, metres_per_unit: float, camera_height_m: tuple[float, float]
) -> Iterator[str]:
    if clear_m is None:
        return
    if doubt := _doubt_of_unit(clear_m, metres_per_unit):
        yield doubt
    elif camera_height_m[1] >= clear_m:
        yield (
            f"the eye is up to {camera_height_m[1]:g} m above the floor, and the ceiling {clear_m:.3g} m: "
            "lower camera_height_m"
        )


def doubt_of_open_height(height_m: float, metres_per_unit: float) -> str | None:
    """A doubt about a world without ceilings, of which no height of rooms tells the unit."""
    unit = likely_unit(height_m, metres_per_unit)
    if height_m <= _TOWERS_M or unit is None:
        return None
    return f"the world is {height_m:.3g} m high: towers, or a file in {unit}?"


def doubt_of_tilt(area: NDArray[np.float64]) -> str | None:
    """A doubt about a model whose floors and walls face along no axis, wherever it is turned in plan.

    `area`: (4,) that faces along each axis of the file, and all of it.
    """
    if area[:3].sum() >= _LEAST_UPRIGHT * area[3]:
        return None
    return (
        f"only {area[:3].sum() / area[3]:.0%} of its surface faces along an axis, so floors are tilted: if "
        "its coordinates are those of the whole Earth (ECEF), export it in a local frame with z up, or in UTM"
    )


def doubt_of_up(area: NDArray[np.float64], up: str) -> str | None:
    """A doubt about the axis that a format has upwards, where floors and ceilings lie across another.

    `area`: (4,) that faces along each axis of the file, and all of it.
    """
    facing_m2 = area[:3]
    likely = "xyz"[int(np.argmax(facing_m2))]
    if facing_m2["xyz".index(likely)] <= _MUCH_MORE * facing_m2["xyz".index(up)]:
        return None
    return (
        f"most surface faces {likely}, not {up} as the format has it: if floors stand upright, up: {likely}"
    )


def likely_unit(height_m: float, metres_per_unit: float) -> str | None:
    """The unit in which a height would be one of a room, and the setting for it.

    >>> likely_unit(280.0, 1.0), likely_unit(2.8e-3, 1.0), likely_unit(9000.0, 1.0)
    ('centimetres: metres_per_unit 0.01', 'kilometres: metres_per_unit 1000', None)
    """
    for name, unit in _UNITS_M.items():
        if _USUAL_M[0] <= height_m * unit <= _USUAL_M[1]:
            return f"{name}: metres_per_unit {metres_per_unit * unit:g}"
    return None


def _doubt_of_unit(clear_m: float, metres_per_unit: float) -> str | None:
    if _FEET_M[0] <= clear_m <= _FEET_M[1]:
        feet = f"metres_per_unit {metres_per_unit * _UNITS_M['feet']:g}"
        return f"the ceiling is {clear_m:.3g} m above the floor: a hall, or a file in feet? ({feet})"
    if _LOW_M <= clear_m <= _HIGH_M:
        return None
    unit = likely_unit(clear_m, metres_per_unit)
    guess = f"; is the file in {unit}?" if unit else ": check metres_per_unit"
    return f"the ceiling is {clear_m:.3g} m above the floor{guess}"


def clear_height_m(occlusion: Occlusion, floor_m: NDArray[np.float64]) -> float | None:
    """Median height of ceilings above places to stand; None where most lie under the sky [m]."""
    if not len(floor_m):
        return None
    chosen = floor_m[np.linspace(0, len(floor_m) - 1, min(len(floor_m), 500)).astype(int)]
    start = (chosen + np.array([0, 0, _LIFT_M])).astype(np.float32)
    hits = occlusion.first_hits(start, np.tile(np.array([0, 0, 1], np.float32), (len(start), 1)))
    roofed = hits.triangle >= 0
    if roofed.mean() < 0.5:
        return None
    return float(np.median(hits.distance_m[roofed])) + _LIFT_M
