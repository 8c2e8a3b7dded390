"""Exposure control: how long a camera looks next, by what it has seen."""

from __future__ import annotations

from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from tacos_framework.settings import Settings
from tacos_framework.values import Exposure, ImageContext


class Controller(Protocol):
    """Sets exposure time and gain of a camera from frame to frame.

    Each camera of a rig is controlled by itself. It begins every walk with the exposure of the scenario; the
    frame that is taken with an exposure is then given to `adjust`, which says how the next one is taken. So
    a controller knows frames before the one it exposes, never that one.

    Candidates are evaluated in any order and process, so the object itself keeps nothing between calls. What
    it must know of earlier frames it keeps in ``context.memory``, which is empty at the start of each walk.

    `ControllerBase` has an optional member.
    """

    Config: ClassVar[type[Settings]]

    def adjust(
        self, frame_dn: NDArray[np.uint8] | NDArray[np.uint16], *, exposure: Exposure, context: ImageContext
    ) -> Exposure:
        """The exposure of the next frame.

        - `frame_dn`: (H, W, C) frame as the sensor's file has it, C = 1 or 3, effects on files included [DN].
        - `exposure`: what it was taken with.
        - `context`: black and white level of the file [DN], and the controller's memory.
        """
        ...


class ControllerBase:
    """Optional members of a `Controller`, with their defaults."""

    warm_up_frames: int = 0
    """How many frames of the first view of a walk the camera has taken before the first that counts: a
    camera is rarely switched on as its episode begins."""
