"""The image moves while the shutter is open."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import (
    Captures,
    ImageContext,
    ImageGeometry,
    LookAlike,
    Settings,
    ShownBy,
    Stage,
    physical,
    setting,
    structured,
)
from tacos_plugins.effects import observations
from tacos_plugins.effects.blur import blur, kernel_of, line_transfer
from tacos_plugins.effects.samples import Samples
from tacos_plugins.effects.shown_by import EDGES_OR_MOTION

_DIRECTIONAL = 1.5
"""Gradients kept in one direction, over those in another, from which on blur seems to have a direction."""


class MotionBlur:
    """Smears the light evenly along a straight line, alike all over the image.

    The line lies half on either side of each pixel, so that the image does not shift. Its transfer is
    ``sin(pi L f) / (pi L f)`` for frequencies along it and 1 across.
    """

    class Config(Settings):
        length_px: float = setting(
            0.0, help="Length of the path during the exposure.", unit="px", ge=0, le=200
        )
        speed_deg_s: float | None = physical(
            "length_px",
            help="Speed of the camera's turn, in place of length_px: by it the path follows from exposure "
            "time and focal length.",
            unit="deg/s",
            ge=0,
            le=1e4,
        )
        angle_deg: float = setting(
            0.0,
            help="Direction of the path: 0 along the rows, 90 along the columns, turning clockwise.",
            unit="deg",
            ge=-360,
            le=360,
            period=180.0,
        )

    stage: ClassVar[Stage] = "exposure"
    rank: ClassVar[int] = 10
    neutral: ClassVar[Mapping[str, Any]] = {"length_px": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = (
        {"length_px": 5.0, "angle_deg": 0.0},
        {"length_px": 5.0, "angle_deg": 45.0},
        {"length_px": 5.0, "angle_deg": 90.0},
        {"length_px": 5.0, "angle_deg": 135.0},
    )
    look_alikes: ClassVar[Sequence[LookAlike]] = tuple(
        LookAlike(
            other,
            observations.edges_of_one_direction,
            "edge",
            "an edge across the other, with the same settings: motion blurs along one line, a lens all round",
        )
        for other in ("defocus", "lens-blur")
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (EDGES_OR_MOTION,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def guesses_from(cls, captures: Captures) -> Iterator[Mapping[str, Any]]:
        """The direction whose gradients have lost most against what is expected, at unusual lengths."""
        steepest: tuple[float, float] = (_DIRECTIONAL, 0.0)
        for capture in structured(captures):
            if capture.expected_dn is None:
                continue
            real, expected = (
                gradient_energy(f.mean(axis=0), capture.valid) for f in (capture.real_dn, capture.expected_dn)
            )
            angles = np.arange(0.0, 180.0, 5.0)
            along = np.stack([np.cos(np.radians(angles)), np.sin(np.radians(angles))])
            left, whole = (np.einsum("ia,ij,ja->a", along, energy, along) for energy in (real, expected))
            kept = left / whole
            anisotropy = float(kept.max() / max(kept.min(), 1e-9))
            if anisotropy > steepest[0]:
                steepest = anisotropy, float(angles[np.argmin(kept)])
        if steepest[0] > _DIRECTIONAL:
            for length in (10.0, 22.0):
                yield {"length_px": length, "angle_deg": steepest[1]}

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        length_px = self.config.length_px
        if length_px == 0.0:
            return signal
        transfer = line_transfer(length_px, self.config.angle_deg)
        return blur(signal, kernel_of(transfer, reach_px=length_px / 2))


def gradient_energy(image: NDArray[np.floating], valid: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(2, 2) mean outer product of the gradient of an (H, W, C) image, x before y [DN^2 per px^2]."""
    down, right = np.gradient(image.mean(axis=-1))
    gradients = np.stack([right[valid], down[valid]])
    return np.asarray(gradients @ gradients.T / gradients.shape[1] + 1e-6 * np.eye(2), np.float64)
