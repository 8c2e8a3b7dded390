"""View directions of cameras on the agent: pure geometry behind the drawings.

Angles are in degrees, pitch positive up, heights and distances in metres. Image coordinates here are in units
of the focal length: x right, y down, the optical axis at (0, 0).
"""

from __future__ import annotations

import math
from collections.abc import Mapping

Point = tuple[float, float]


def floor_range_m(eye_height_m: float, pitch_deg: float, vfov_deg: float) -> tuple[float, float] | None:
    """Nearest and farthest floor seen straight ahead [m]; None where the camera sees no floor.

    The farthest is infinite when the horizon is in view. A view that reaches past straight down begins at 0.

    >>> near, far = floor_range_m(1.5, -45.0, 30.0)
    >>> round(near, 2), round(far, 2)
    (0.87, 2.6)
    """
    lowest, highest = pitch_deg - vfov_deg / 2, pitch_deg + vfov_deg / 2
    if lowest >= 0 or highest <= -90:
        return None
    near = 0.0 if lowest <= -90 else eye_height_m / math.tan(math.radians(-lowest))
    far = math.inf if highest >= 0 else eye_height_m / math.tan(math.radians(-highest))
    return near, far


def wedge(
    apex: Point, from_deg: float, to_deg: float, radius_m: float, floor: float | None = None
) -> list[Point]:
    """Outline of a field of view in a vertical or horizontal plane [m], cut off at height `floor`."""
    steps = max(2, round(to_deg - from_deg))
    outline = [apex]
    for step in range(steps + 1):
        angle = math.radians(from_deg + (to_deg - from_deg) * step / steps)
        reach = radius_m
        if floor is not None and math.sin(angle) < 0:
            reach = min(reach, (apex[1] - floor) / -math.sin(angle))
        outline.append((apex[0] + reach * math.cos(angle), apex[1] + reach * math.sin(angle)))
    return outline


def outlooks(derived: Mapping[str, float]) -> list[tuple[float, float]]:
    """Turn to the left and horizontal field of view of each camera of a rig [deg].

    A rig tells by what it derives: ``cameras`` is the number of an even ring, of which ``first_yaw_deg`` is
    the first; ``side_yaw_deg`` with ``side_hfov_deg`` is a pair of sides, ``back_hfov_deg`` a camera behind.

    >>> outlooks({"hfov_deg": 80.0, "cameras": 2.0, "first_yaw_deg": 30.0})
    [(30.0, 80.0), (210.0, 80.0)]
    >>> outlooks({"hfov_deg": 60.0, "cameras": 2.0, "back_hfov_deg": 100.0})
    [(0.0, 60.0), (180.0, 100.0)]
    """
    first = derived.get("first_yaw_deg", 0.0), derived["hfov_deg"]
    others = []
    if (side := derived.get("side_hfov_deg")) is not None:
        others += [(derived["side_yaw_deg"], side), (-derived["side_yaw_deg"], side)]
    if (back := derived.get("back_hfov_deg")) is not None:
        others.append((180.0, back))
    if others:
        return [first, *others]
    count = int(derived.get("cameras", 1))
    return [(first[0] + i * 360 / count, first[1]) for i in range(count)]


def half_extents(hfov_deg: float, vfov_deg: float) -> Point:
    """Half width and half height of an image in focal lengths."""
    return math.tan(math.radians(hfov_deg / 2)), math.tan(math.radians(vfov_deg / 2))


def footprint(extents: Point, pitch_deg: float, seen_from_pitch_deg: float) -> list[Point] | None:
    """The frame of one camera as another at the same place, of another pitch, sees it.

    - `extents`: half width and half height of the first camera's image [focal lengths].

    Returns: corners from top left clockwise; None when one lies behind the other camera.
    """
    turn = math.radians(pitch_deg - seen_from_pitch_deg)
    half_width, half_height = extents
    corners = []
    for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
        # rotation about the image's x axis; pitching up moves the frame up, towards negative y
        v = y * half_height * math.cos(turn) - math.sin(turn)
        depth = y * half_height * math.sin(turn) + math.cos(turn)
        if depth <= 0.05:
            return None
        corners.append((x * half_width / depth, v / depth))
    return corners


def horizon_from_top(half_height: float, pitch_deg: float) -> float:
    """Distance of the horizon below an image's upper edge [focal lengths]; negative when above it."""
    return half_height + math.tan(math.radians(pitch_deg))
