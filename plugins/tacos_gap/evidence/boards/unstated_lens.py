"""A focal length that nobody stated, from the boards: where all geometry begins."""

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

_ASIDE = 0.05


def with_lens_of_boards(captures: Sequence[RealCapture]) -> tuple[tuple[RealCapture, ...], list[str]]:
    """Captures with the focal length and centre their boards tell, where unstated; and what was done.

    It stays free: boards are adjusted to it under every hypothesis.
    """
    captures = tuple(captures)
    unstated = captures[0].unstated if captures else frozenset()
    if "focal_length" not in unstated:
        return captures, []
    boards = [capture for capture in captures if capture.corners is not None]
    free = ("focal_length", "principal_point") if "principal_point" in unstated else ("focal_length",)
    found = _calibrated(boards, free)
    pixel_um = captures[0].geometry.pixel_um
    if found is None or _focal_spread(boards, found, free) > SURE:
        assumed_mm = captures[0].geometry.focal_length_px * pixel_um * 1e-3
        reason = "no board tells it" if found is None else "the boards do not settle it, tilt them more"
        return captures, [
            f"focal_length_mm is nobody's claim and {reason}: {assumed_mm:g} mm is assumed. "
            f"Nothing is said about it."
        ]
    told = f"{found.focal_px * pixel_um * 1e-3:.3g} mm ({found.focal_px:.4g} px)"
    said = (
        f"focal_length_mm is nobody's claim: the boards tell {told}, and it stays free with every "
        f"explanation. Nothing is said about it as a cause."
    )
    return tuple(replace(c, geometry=_with_lens(c.geometry, found)) for c in captures), [said]


def _calibrated(boards: Sequence[RealCapture], free: Collection[str]) -> Calibration | None:
    """By Brown and Conrady's model, or a fisheye's where that leaves much less."""
    brown, fisheye = (calibrated(boards, free=free, fisheye=kind) for kind in (False, True))
    if brown and fisheye:
        return fisheye if fisheye.rms_px < MUCH_LESS * brown.rms_px else brown
    return brown or fisheye


def _focal_spread(boards: Sequence[RealCapture], found: Calibration, free: Collection[str]) -> float:
    """Relative standard deviation of the focal length, by how much worse the views fit another one.

    All else is fitted anew: views that face the camera fit any.
    """
    other_px = (1 + _ASIDE) * found.focal_px
    held = [replace(c, geometry=replace(c.geometry, focal_length_px=other_px)) for c in boards]
    other = calibrated(held, free=[name for name in free if name != "focal_length"])
    if other is None or other.rms_px <= found.rms_px:
        return np.inf
    numbers = sum(capture.corners[1].size for capture in boards if capture.corners is not None)
    worse = other.rms_px**2 / found.rms_px**2 - 1
    return float(_ASIDE / np.sqrt(numbers * worse))


def _with_lens(geometry: ImageGeometry, found: Calibration) -> ImageGeometry:
    centre = np.array(geometry.centre_px) + found.moved_px
    return replace(geometry, focal_length_px=found.focal_px, centre_px=(float(centre[0]), float(centre[1])))
