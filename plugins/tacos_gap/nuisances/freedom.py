"""Nuisances of a capture, and the priors of each.

Light is free within the stated ``level_uncertainty`` alone: who states none claims to know her lamp. Pose and
focus of a structured picture are never known exactly, so each of them has a prior of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture
from tacos_plugins.effects.mosaic_cells import cell_means

SHIFT_PX = 0.5
"""Standard deviation of a shift: where a camera stands is known to about a pixel [px]."""

ROTATION_DEG = 0.1
"""Of a rotation about the optical axis [deg]."""

SCALE = 0.0005
"""Of a magnification: two millimetres at four metres."""

TILT_DEG = 0.2
"""Of a tilt of what is seen against the picture's plane: nobody hangs a target straighter [deg]."""

BLUR_PX2 = 0.03
"""Of the variance of a blur: a disc of a third of a pixel [px^2]."""

NOISE_SHARE = 0.35
"""Of the variance of noise that an expectation holds although none is stated, over that of a frame: means of
few frames and paths are taken for exact."""

NOISE_SHARE_OF_BRACKET = 1.0
"""The same of a series of exposures, whose expectation is commonly scaled from its other exposures: that of
the longest holds more noise than a frame."""

UNEVENNESS = 0.5
"""Slopes of the light over the image, over ``level_uncertainty``."""

LEAST_STRUCTURE = 0.02
"""Range of an expectation, over full scale, from which on it can be registered."""


@dataclass(frozen=True)
class Freedom:
    name: str
    sigma: float
    channel: int | None = None
    share: float = 1.0

    @property
    def is_followed(self) -> bool:
        """True if an expectation can be made that has it; noise cannot be taken out of one."""
        return self.name != "noise_share"

    def within(self, share: float) -> Freedom:
        return replace(self, sigma=self.sigma * share / self.share, share=share)


LIGHT_TERMS = ("light_x", "light_y", "light_xy", "light_saddle")
"""Smooth light, relative: x, y, xy and x^2 - y^2 over half the image. Not r^2: a lamp that falls off around
the optical axis in every flat is vignetting, until the camera is turned."""

POSE_TERMS = ("shift_x_px", "shift_y_px", "rotation_deg", "scale", "tilt_x_deg", "tilt_y_deg")
_POSE_SIGMAS = (SHIFT_PX, SHIFT_PX, ROTATION_DEG, SCALE, TILT_DEG, TILT_DEG)


def freedoms_of(capture: RealCapture) -> tuple[Freedom, ...]:
    """The nuisances of a capture; none for darks, boards (whose poses are fitted) and exact flats."""
    if capture.expected_dn is None or capture.kind in ("dark", "board"):
        return ()
    found: list[Freedom] = []
    if capture.level_uncertainty:
        channels = capture.expected_dn.shape[-1]
        one = channels == 1
        found += [Freedom("gain", capture.level_uncertainty, None if one else c) for c in range(channels)]
        found += [Freedom(name, UNEVENNESS * capture.level_uncertainty) for name in LIGHT_TERMS]
    if _is_registrable(capture):
        if not capture.own_edges:  # those stand where the picture has them
            found += [Freedom(name, sigma) for name, sigma in zip(POSE_TERMS, _POSE_SIGMAS, strict=True)]
        found += [Freedom("blur_px2", BLUR_PX2)]
        if not capture.expected_frames:
            share = NOISE_SHARE_OF_BRACKET if capture.kind == "bracket" else NOISE_SHARE
            found += [Freedom("noise_share", share)]
    return tuple(found)


def _is_registrable(capture: RealCapture) -> bool:
    if not capture.is_structured:
        return False
    assert capture.expected_dn is not None
    seen = capture.expected_dn[0][capture.valid]
    if capture.context.cfa:  # its colours differ in an even picture, too
        seen = cell_means(capture.expected_dn[0, ..., 0])[cell_means(capture.valid) == 1][:, None]
    full = capture.context.white_level_dn - capture.context.black_level_dn
    return bool(seen.size and np.ptp(seen.mean(axis=-1)) > LEAST_STRUCTURE * full)


def stated(freedoms: Sequence[Freedom], nu: NDArray[np.float64]) -> dict[str, Any]:
    """Nuisances as ``diagnosis.json`` has them, in their units.

    `nu`: (F,) their values, in standard deviations of the priors.
    """
    value = {(f.name, f.channel): float(n * f.sigma) for f, n in zip(freedoms, nu, strict=True)}
    names = {name for name, _ in value}
    plain: dict[str, Any] = {}
    if "gain" in names:
        gains = [round(1 + v, 5) for (name, _), v in value.items() if name == "gain"]
        plain["gain"] = gains[0] if len(gains) == 1 else gains
    if "light_x" in names:
        plain["light"] = {name.removeprefix("light_"): round(value[name, None], 5) for name in LIGHT_TERMS}
    if "shift_x_px" in names:
        plain["shift_px"] = [round(value[name, None], 3) for name in POSE_TERMS[:2]]
        plain["rotation_deg"] = round(value["rotation_deg", None], 4)
        plain["scale"] = round(1 + value["scale", None], 6)
        plain["tilt_deg"] = [round(value[name, None], 4) for name in POSE_TERMS[4:]]
    if "blur_px2" in names:
        plain["blur_px2"] = round(value["blur_px2", None], 4)
    if "noise_share" in names:
        plain["noise_share"] = round(value["noise_share", None], 3)
    return plain
