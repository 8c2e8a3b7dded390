"""Rows that are exposed one after another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import ImageContext, ImageGeometry, LookAlike, Settings, ShownBy, Stage, setting
from tacos_framework.camera import Places, nearest
from tacos_plugins.effects import observations
from tacos_plugins.effects.pixel_sources import source_of
from tacos_plugins.effects.shown_by import MOTION


class RollingShutter:
    """Shows each row at its own moment: what moves is sheared, stretched or bent.

    Row y is read out ``(y - reference row) row_time_us`` after the moment of the frame, and what moves at v
    has gone on by v times that; rows are those of photosites. Of rendered views v follows from the agent's
    motion and the depth, the middle row keeps the frame's moment, and truth is moved along; worlds stand
    still, so only the camera moves. Elsewhere v is the context's `velocity_px_s`. Velocity is taken as
    constant over the readout. What a near thing uncovers is not known; the rim of its surroundings is drawn
    out there.

    Source: Meingast, Geyer and Sastry 2005, "Geometric models of rolling-shutter cameras", OMNIVIS.
    """

    class Config(Settings):
        row_time_us: float = setting(
            0.0,
            help="Time from row to row; 20 to 80 us is usual, below 0 the last row comes first.",
            unit="us",
            ge=-1000,
            le=1000,
        )

    stage: ClassVar[Stage] = "exposure"
    rank: ClassVar[int] = 0
    neutral: ClassVar[Mapping[str, Any]] = {"row_time_us": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"row_time_us": 30.0}, {"row_time_us": -30.0})
    look_alikes: ClassVar[Sequence[LookAlike]] = (
        LookAlike(
            "pose-error",
            observations.one_velocity,
            "sequence",
            "another velocity: readout bends by it, a pose does not",
        ),
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (MOTION,)

    def __init__(self, config: Config) -> None:
        self.config = config

    def source(self, *, geometry: ImageGeometry, context: ImageContext, frames: int) -> Places | None:
        """Places in the image of the frame's moment at which pixels look, (N, H, W) columns and rows; None
        where off [px].
        """
        if self.config.row_time_us == 0.0:
            return None
        velocity = context.known_velocity_px_s("effect.rolling-shutter")
        size = (frames, geometry.height_px, geometry.width_px)
        velocity_x = np.broadcast_to(velocity[..., 0], size)
        velocity_y = np.broadcast_to(velocity[..., 1], size)
        row = np.arange(geometry.height_px, dtype=np.float64)[:, None]
        later_s = (row - context.reference_row) * geometry.binning * self.config.row_time_us * 1e-6

        def moved(x: NDArray[np.float64], y: NDArray[np.float64]) -> Places:
            return x + nearest(velocity_x, x, y) * later_s, y + nearest(velocity_y, x, y) * later_s

        return source_of(geometry, moved, frames)
