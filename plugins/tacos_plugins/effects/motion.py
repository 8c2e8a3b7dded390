"""The image moves while rows are exposed: blur and rolling shutter of what is rendered."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, ImageContext, ImageGeometry, Rig, Settings, ShownBy, Stage, setting
from tacos_framework.camera import TYPICAL_ROW_TIME_US
from tacos_plugins.effects.image_paths import ImageMotion, RowAfter
from tacos_plugins.effects.path_average import Shown, along_paths
from tacos_plugins.effects.samples import Samples
from tacos_plugins.effects.shown_by import MOTION

_NOWHERE_PX = 1e-3
"""Motion below which a thing stands still [px]."""


class Motion:
    """Blurs each pixel along its own way during the exposure, and exposes rows when the shutter does.

    The way follows from the agent's trajectory, the depth of the pixel and the ways of things that move by
    themselves; of images that are not rendered, from their `velocity_px_s`. It is a straight line with the
    mean of the true, bent one; where it bends by more than a tenth of a pixel it is cut into parts. Light,
    depth and ids of a row are those of the middle of its exposure; the frame's moment is that of the middle
    row. What a near thing covers or uncovers during the exposure keeps the way of the middle.

    Whether the shutter is rolling, and its line time, are the camera's; no line takes longer than its frame
    rate leaves. Rows binned on the sensor are read one by one, rows outside a region of interest are not
    read.

    Source: Meingast, Geyer and Sastry 2005, "Geometric models of rolling-shutter cameras", OMNIVIS.
    """

    class Config(Settings):
        amount: float = setting(
            1.0, help="Motion that is simulated over that of the scene: 0 is none, 1 all of it.", ge=0, le=10
        )
        shutter: Literal["part", "global", "rolling"] = setting(
            "part", help="Exposure of the rows: that of the image sensor (part), all at once, or one by one."
        )
        row_time_us: float | None = setting(
            None,
            help="Time from row to row of a rolling shutter, in place of the part's.",
            unit="us",
            ge=0,
            le=1000,
        )
        unknown: Literal["assume", "refuse"] = setting(
            "assume",
            help="For image sensors without a published shutter or line time: assume a global shutter and "
            "assumed_row_time_us, or refuse the sensor.",
        )
        assumed_row_time_us: float = setting(
            TYPICAL_ROW_TIME_US,
            help="Line time of rolling shutters where it is unknown; by default the median of known ones.",
            unit="us",
            ge=0,
            le=1000,
        )

    stage: ClassVar[Stage] = "exposure"
    rank: ClassVar[int] = -10
    neutral: ClassVar[Mapping[str, Any]] = {"amount": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ()
    shown_by: ClassVar[Sequence[ShownBy]] = (MOTION,)

    def __init__(self, config: Config) -> None:
        self.config = config

    def lacks(self, rig: Rig) -> str | None:
        if self.config.unknown == "assume" or not self.config.amount:
            return None
        unknown = {_named(each): self._unknown_of(each) for each in rig.cameras}
        said = [f"{figure} of {name}" for name, figure in unknown.items() if figure]
        return f"{' and '.join(said)} is unknown" if said else None

    def origins(self, camera: Camera) -> Mapping[str, str]:
        if not self.config.amount:
            return {}
        shutter, unknown = self._shutter(camera.shutter), self._unknown_of(camera)
        source = "as the catalog states" if self.config.shutter == "part" else "as the recipe sets"
        said = {"shutter": f"{shutter}, {source}"}
        if unknown == "the shutter":
            said = {"shutter": "assumed global: not published"}
        if shutter == "rolling":
            said["line time"] = self._said(camera, unknown is not None)
        return said

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        """Light averaged along the path of each pixel."""
        frames = [self._moved(each, geometry, context, i) for i, each in enumerate(signal)]
        if not any(frames):
            return signal
        return np.stack(
            [found.light if found else each for found, each in zip(frames, signal, strict=True)]
        ).astype(signal.dtype, copy=False)

    def on_view(
        self,
        light: NDArray[np.float32],
        depth_m: NDArray[np.float32],
        object_id: NDArray[np.int32],
        *,
        geometry: ImageGeometry,
        context: ImageContext,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.int32]]:
        """Light as above, depth and ids in the middle of each row's exposure."""
        found = self._moved(light[0], geometry, context, 0)
        if found is None:
            return light, depth_m, object_id
        if found.shown is None:
            return found.light[None], depth_m, object_id
        return found.light[None], found.shown.depth_m[None], found.shown.object_id[None]

    def _moved(
        self, frame: NDArray[np.floating], geometry: ImageGeometry, context: ImageContext, index: int
    ) -> _Moved | None:
        """One (H, W, C) frame with the effect; None where nothing moves."""
        if self.config.amount == 0.0:
            return None
        motion = ImageMotion.of(geometry, context, index)
        row_after_s = self._row_after_s(geometry, context)
        paths = motion.paths(row_after_s, self.config.amount * context.exposure_s)
        if paths.reach_px < _NOWHERE_PX:
            return None
        if not self._row_time_of_image_us(geometry, context):
            return _Moved(along_paths(frame, motion.near, motion.table_of, paths), None)
        middle = motion.middle(row_after_s)
        shown = Shown.at(motion.near, motion.table_of, motion.object_id, middle)
        return _Moved(along_paths(frame, shown.near, shown.table_of, paths), shown)

    def _row_after_s(self, geometry: ImageGeometry, context: ImageContext) -> RowAfter:
        """Takes rows to the middles of their exposures after the frame's moment [px, s]."""
        step_s = self.config.amount * 1e-6 * self._row_time_of_image_us(geometry, context)
        return lambda row: (row - context.reference_row) * step_s

    def _row_time_of_image_us(self, geometry: ImageGeometry, context: ImageContext) -> float:
        """From row to row of the image [us]."""
        if self._shutter(context.shutter) == "global":
            return 0.0
        return self._row_time_us(context) * geometry.binning

    def _shutter(self, of_part: str | None) -> str:
        return (of_part or "global") if self.config.shutter == "part" else self.config.shutter

    def _row_time_us(self, part: Camera | ImageContext) -> float:
        """From row to row of photosites where the shutter is rolling [us].

        A line time of the part, or an assumed one, takes no longer than the part's frame rate leaves.
        """
        if self.config.row_time_us is not None:
            return self.config.row_time_us
        row_time_us = self.config.assumed_row_time_us if part.row_time_us is None else part.row_time_us
        return min(row_time_us, math.inf if part.row_time_at_most_us is None else part.row_time_at_most_us)

    def _unknown_of(self, camera: Camera) -> str | None:
        """The unknown figure of a camera that the effect needs."""
        if self.config.shutter == "part" and camera.shutter is None:
            return "the shutter"
        if (
            self._shutter(camera.shutter) == "rolling"
            and self.config.row_time_us is camera.row_time_us is None
        ):
            return "the line time"
        return None

    def _said(self, camera: Camera, assumed: bool) -> str:
        """Origin of a line time."""
        row_time_us = self._row_time_us(camera)
        said = f"{row_time_us:.3g} us a row"
        if self.config.row_time_us is not None:
            return f"{said}, as the recipe sets"
        if row_time_us == camera.row_time_at_most_us:
            return f"{'assumed to be ' if assumed else ''}{said}, all that its frame rate leaves"
        return f"assumed to be {said} (assumed_row_time_us)" if assumed else f"{said}, as the catalog states"


def _named(camera: Camera) -> str:
    return camera.electrons.sensor or f"camera {camera.name!r}"


@dataclass(frozen=True, eq=False)
class _Moved:
    """A frame that has moved: (H, W, C) light, and what it shows where rows are exposed one by one."""

    light: NDArray[np.float32]
    shown: Shown | None
