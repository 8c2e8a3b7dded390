"""A focal length that nobody stated, from the boards: where all geometry begins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tacos_framework.values import ImageGeometry
from tacos_gap.captures.capture import RealCapture
from tacos_plugins.effects.board_calibration import Calibration, calibrated

SURE = 0.03
"""Relative standard deviation up to which boards are said to tell the focal length."""


def with_lens_of_boards(captures: Sequence[RealCapture]) -> tuple[tuple[RealCapture, ...], list[str]]:
    """Captures with the focal length and centre that their boards tell, where nobody stated them; and what was done.

    It stays free: boards are adjusted to it under every hypothesis.
    """
    captures = tuple(captures)
    unstated = captures[0].unstated if captures else frozenset()
    if "focal_length" not in unstated:
        return captures, []
    boards = [capture for capture in captures if capture.corners is not None]
    free = ("focal_length", "principal_point") if "principal_point" in unstated else ("focal_length",)
    found = calibrated(boards, free=free)
    pixel_um = captures[0].geometry.pixel_um
    if found is None or found.focal_spread > SURE:
        assumed_mm = captures[0].geometry.focal_length_px * pixel_um * 1e-3
        reason = "no board tells it" if found is None else "the boards do not settle it, tilt them more"
        return captures, [
            f"focal_length_mm is not stated and {reason}: {assumed_mm:g} mm is assumed. Nothing is said about it."
        ]
    said = (
        f"focal_length_mm is not stated: the boards tell {found.focal_px * pixel_um * 1e-3:.3g} mm "
        f"({found.focal_px:.4g} px, give or take {100 * found.focal_spread:.1g} %), and it stays free. Nothing is said "
        f"about it as a cause."
    )
    return tuple(replace(c, geometry=_with_lens(c.geometry, found)) for c in captures), [said]


def _with_lens(geometry: ImageGeometry, found: Calibration) -> ImageGeometry:
    centre = np.array(geometry.centre_px) + found.moved_px
    return replace(geometry, focal_length_px=found.focal_px, centre_px=(float(centre[0]), float(centre[1])))
