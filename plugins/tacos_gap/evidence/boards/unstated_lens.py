"""Focal length and principal point that are not stated, from the boards: where all geometry begins."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from tacos_framework import ImageGeometry
from tacos_gap.captures.capture import RealCapture
from tacos_plugins.effects.board_calibration import Calibration, calibrated

SURE = 0.03
"""Relative standard deviation up to which boards are said to tell the focal length."""

MUCH_LESS = 0.7
"""Misfit of a fisheye over that of Brown and Conrady's lens, below which the fisheye counts."""

WIDE, AS_GOOD = 1.2, 1.05
"""Half diagonal over the focal length from which on a fisheye that fits as well, to this factor, counts: a
lens of straight lines would see 100 degrees. So all cameras of a rig get one model, however far boards reach.
"""

_ASIDE = 0.05


def with_lens_of_boards(captures: Sequence[RealCapture]) -> tuple[tuple[RealCapture, ...], list[str]]:
    """Captures with the focal length and centre their boards tell, where unstated; and what was done.

    It stays free: boards are adjusted to it under every hypothesis.
    """
    captures = tuple(captures)
    unstated = captures[0].unstated if captures else frozenset()
    boards = [capture for capture in captures if capture.corners is not None]
    free = tuple(name for name in ("focal_length", "principal_point") if name in unstated)
    if not free or (not boards and "focal_length" not in free):
        return captures, []
    found = _calibrated(boards, free)
    if "focal_length" not in free:
        return _with_centre(captures, boards, found)
    pixel_um = captures[0].geometry.pixel_um
    if found is None or _focal_spread(boards, found, free) > SURE:
        assumed_mm = captures[0].geometry.focal_length_px * pixel_um * 1e-3
        reason = "no board shows it" if found is None else "the boards do not settle it, tilt them more"
        return captures, [
            f"focal_length_mm is not stated and {reason}: {assumed_mm:g} mm is assumed, and it is no cause."
        ]
    told = f"{found.focal_px * pixel_um * 1e-3:.3g} mm ({found.focal_px:.4g} px)"
    said = (
        f"focal_length_mm is not stated: the boards give {told}. It stays free with every explanation, "
        f"and is no cause."
    )
    return tuple(replace(c, geometry=_with_lens(c.geometry, found)) for c in captures), [said]


def _with_centre(
    captures: tuple[RealCapture, ...], boards: Sequence[RealCapture], found: Calibration | None
) -> tuple[tuple[RealCapture, ...], list[str]]:
    """Captures with the principal point of boards that settle it, over a stated focal length."""
    if found is None or _centre_spread(boards, found) > SURE:
        return captures, []
    placed = tuple(
        replace(c, geometry=_with_lens(c.geometry, replace(found, focal_px=c.geometry.focal_length_px)))
        for c in captures
    )
    x, y = placed[0].geometry.centre_px
    return placed, [
        f"principal_point_px is not stated: the boards place it at ({x:.0f}, {y:.0f}) px, and it stays free "
        f"with every explanation. Nothing is said about it as a cause."
    ]


def _calibrated(boards: Sequence[RealCapture], free: Collection[str]) -> Calibration | None:
    """By Brown and Conrady's model, or a fisheye's where that leaves much less."""
    brown, fisheye = (calibrated(boards, free=free, fisheye=kind) for kind in (False, True))
    if brown and fisheye:
        whole = boards[0].geometry
        half_diagonal_px = 0.5 * np.hypot(whole.full_width_px, whole.full_height_px)
        wide = half_diagonal_px > WIDE * fisheye.focal_px
        return fisheye if fisheye.rms_px < (AS_GOOD if wide else MUCH_LESS) * brown.rms_px else brown
    return brown or fisheye


def _focal_spread(boards: Sequence[RealCapture], found: Calibration, free: Collection[str]) -> float:
    """Relative standard deviation of the focal length, by how much worse the views fit another one.

    All else is fitted anew: views that face the camera fit any.
    """
    other_px = (1 + _ASIDE) * found.focal_px
    held = [replace(c, geometry=replace(c.geometry, focal_length_px=other_px)) for c in boards]
    return _spread(boards, found, calibrated(held, free=[name for name in free if name != "focal_length"]))


def _centre_spread(boards: Sequence[RealCapture], found: Calibration) -> float:
    """Standard deviation of the principal point over the focal length, in the direction that says less."""
    spreads = []
    for aside in ((_ASIDE, 0.0), (0.0, _ASIDE)):
        moved = replace(found, moved_px=tuple(found.moved_px + np.multiply(aside, found.focal_px)))
        held = [replace(c, geometry=_with_lens(c.geometry, moved)) for c in boards]
        spreads.append(_spread(boards, found, calibrated(held)))
    return max(spreads)


def _spread(boards: Sequence[RealCapture], found: Calibration, other: Calibration | None) -> float:
    """Standard deviation of what another calibration holds `_ASIDE` off the best, by how much worse it is."""
    if other is None or other.rms_px <= found.rms_px:
        return np.inf
    numbers = sum(capture.corners[1].size for capture in boards if capture.corners is not None)
    worse = other.rms_px**2 / found.rms_px**2 - 1
    return float(_ASIDE / np.sqrt(numbers * worse))


def _with_lens(geometry: ImageGeometry, found: Calibration) -> ImageGeometry:
    centre = np.array(geometry.centre_px) + found.moved_px
    return replace(geometry, focal_length_px=found.focal_px, centre_px=(float(centre[0]), float(centre[1])))
