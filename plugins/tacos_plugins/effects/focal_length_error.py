"""A focal length and a principal point other than believed."""

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
    ObservedCapture,
    Settings,
    ShownBy,
    Stage,
    of_kind,
    physical,
    setting,
    structured,
)
from tacos_framework.camera import Places
from tacos_plugins.effects import observations
from tacos_plugins.effects.alignment import aligned_with_expected
from tacos_plugins.effects.board_calibration import calibrated
from tacos_plugins.effects.shown_by import BOARDS

LEAST_MOVE_PX = 1.0
"""Move of a corner of a picture from which on it is looked into [px]."""


class FocalLengthError:
    """Magnifies the image about the principal point, and shifts it.

    A point seen at c + d by the believed camera is seen at c + scale d + (dx, dy). On a plane square to the
    optical axis another distance does the same. Where the real camera sees more than was rendered, the edge
    of the image is drawn out.
    """

    class Config(Settings):
        scale: float = setting(1.0, help="Real over believed focal length.", ge=0.2, le=5)
        dx_px: float = setting(
            0.0, help="Real minus believed principal point, to the right.", unit="px", ge=-1e4, le=1e4
        )
        dy_px: float = setting(
            0.0, help="Real minus believed principal point, downwards.", unit="px", ge=-1e4, le=1e4
        )
        dx_um: float | None = physical(
            "dx_px", help="The same to the right, on the sensor.", unit="um", ge=-1e5, le=1e5
        )
        dy_um: float | None = physical(
            "dy_px", help="The same downwards, on the sensor.", unit="um", ge=-1e5, le=1e5
        )

    stage: ClassVar[Stage] = "optics"
    rank: ClassVar[int] = 0
    neutral: ClassVar[Mapping[str, Any]] = {"scale": 1.0, "dx_px": 0.0, "dy_px": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"scale": 1.01}, {"dx_px": 2.0}, {"dy_px": 2.0})
    look_alikes: ClassVar[Sequence[LookAlike]] = (
        LookAlike(
            "pose-error",
            observations.flat_on,
            "board",
            "tilted views tell the focal length from the distance",
        ),
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (BOARDS,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def guesses_from(cls, captures: Captures) -> Iterator[Mapping[str, Any]]:
        """Calibration by boards, with a lens that distorts and without, or how pictures of scenes align."""
        for terms in (0, 2):
            if found := calibrated(captures, terms=terms, free=("focal_length", "principal_point")):
                scale = found.focal_px / of_kind(captures, "board")[0].geometry.focal_length_px
                yield {"scale": scale, "dx_px": found.moved_px[0], "dy_px": found.moved_px[1]}
        if moves := [move for each in structured(captures) if (move := _as_aligned(each)) is not None]:
            yield dict(zip(("scale", "dx_px", "dy_px"), np.median(moves, axis=0).tolist(), strict=True))

    @property
    def _off(self) -> bool:
        return (self.config.scale, self.config.dx_px, self.config.dy_px) == (1.0, 0.0, 0.0)

    def source(self, *, geometry: ImageGeometry, context: ImageContext, frames: int) -> Places | None:
        """Places in the believed image at which pixels of the real one look, (H, W); None where off [px]."""
        if self._off:
            return None
        cx, cy = geometry.centre_px
        x, y = np.broadcast_arrays(geometry.x_px + cx, geometry.y_px + cy)
        return self.source_at(x, y, geometry=geometry)

    def source_at(
        self, x_px: NDArray[np.float64], y_px: NDArray[np.float64], *, geometry: ImageGeometry
    ) -> Places:
        """Places in the believed image at which points of the real one look [px]."""
        cx, cy = geometry.centre_px
        c = self.config
        return cx + (x_px - cx - c.dx_px) / c.scale, cy + (y_px - cy - c.dy_px) / c.scale


def _as_aligned(capture: ObservedCapture) -> tuple[float, float, float] | None:
    """Scale and shift by which a picture aligns with its expectation; None where it hardly moves."""
    if capture.own_edges or (matrix := aligned_with_expected(capture)) is None:
        return None
    centre = np.asarray(capture.geometry.centre_px, float)
    scale = float(np.trace(matrix[:, :2])) / 2
    dx, dy = matrix @ [*centre, 1.0] - centre
    corner_px = float(np.hypot(capture.geometry.width_px, capture.geometry.height_px)) / 2
    moves = np.hypot(dx, dy) + abs(scale - 1) * corner_px
    return (scale, float(dx), float(dy)) if moves > LEAST_MOVE_PX else None
