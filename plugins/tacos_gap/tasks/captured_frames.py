"""Frames of a capture as tasks see those of a simulated walk, with what is known of the world behind them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Capture as Light
from tacos_framework import Episode, FrameBatch, Object, Trajectory, View, World
from tacos_gap.captures import RealCapture
from tacos_gap.simulation.sensors import camera_of

BACKGROUND = "background"
SOON_S = 1 / 30
"""From frame to frame where nobody says: tasks that match take frames for neighbours only soon after [s]."""

_FULL_8_BIT = 255

_MEANINGS = {
    "depth_m": "how far away things are (depth)",
    "object_id": "which object each pixel shows",
    "luminance_cd_m2": "the light in cd/m2",
}


class TruthMissing(RuntimeError):
    """A task reads truth of the world that nobody stated for a capture."""

    def __init__(self, name: str) -> None:
        super().__init__(f"it needs to know {_MEANINGS[name]}")


@dataclass(frozen=True, eq=False)
class CapturedView(View):
    """View of a real camera; reading what is unknown raises `TruthMissing`."""

    unknown: frozenset[str] = frozenset()
    """Arrays of the view that hold nothing. They are hidden once the frames are put together, as their shapes
    are checked then."""

    def __getattribute__(self, name: str) -> Any:
        if name in _MEANINGS and name in object.__getattribute__(self, "__dict__").get("unknown", ()):
            raise TruthMissing(name)
        return object.__getattribute__(self, name)


def as_batch(capture: RealCapture, frames_dn: NDArray[np.float32]) -> FrameBatch:
    """Frames of a capture as those of a simulated walk.

    The view of the batch refuses to give what the capture does not carry.
    """
    count, height, width = frames_dn.shape[:3]
    context, objects = capture.context, capture.objects
    shape = (count, height, width)
    depth_m = np.asarray(np.inf if context.depth_m is None else context.depth_m, np.float32)
    ids = np.int32(0) if objects is None else objects.ids
    view = CapturedView(
        camera_of(capture),
        np.tile(np.eye(4), (count, 1, 1)),
        np.broadcast_to(np.float32(0), (*shape, 3)),
        np.broadcast_to(depth_m[:count] if depth_m.ndim == 3 else depth_m, shape),
        np.broadcast_to(ids, shape),
    )
    classes = (BACKGROUND,) if objects is None else objects.classes
    things = tuple(Object(f"{name}_{i}" if i else name, name) for i, name in enumerate(classes))
    world = World("captures", (), (), things, tuple(dict.fromkeys(classes)))
    path = Trajectory(np.zeros(1), np.eye(4)[None])
    interval_s = context.frame_interval_s or SOON_S
    times_s = np.arange(count, dtype=np.float64) * interval_s
    episode = Episode(world, path, times_s, np.zeros(count, np.int32))
    narrow = context.white_level_dn <= _FULL_8_BIT
    images = frames_dn.astype(np.uint8) if narrow else frames_dn.astype(np.uint16)
    batch = FrameBatch(Light(episode, (view,)), (images,), context.black_level_dn, context.white_level_dn)
    known = {"depth_m": context.depth_m is not None, "object_id": objects is not None}
    hidden = frozenset(name for name in _MEANINGS if not known.get(name, False))
    object.__setattr__(view, "unknown", hidden)
    return batch
