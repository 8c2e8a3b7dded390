"""One trip of the agent through a world."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tacos_framework.values.arrays import read_only
from tacos_framework.values.world import World

if TYPE_CHECKING:
    from scipy.spatial.transform import Slerp

_BEYOND_S = 0.1
"""Length of a way's continuation beyond its ends, longer than any exposure in motion [s]."""


TRUTHS = ("geometry", "poses", "depth", "objects")
"""What scenes know beside light, and a recording may not: surfaces that can be drawn, where the agent is, how
far what it sees is, and what that is."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """The agent's pose over time, interpolated between keys."""

    time_s: NDArray[np.float64]
    """(K,) float64, rising [s]."""
    world_from_agent: NDArray[np.float64]
    """(K, 4, 4) float64 rigid transforms [m]; agent x forward, y left, z up, origin at the eye."""

    def __post_init__(self) -> None:
        read_only(self, "time_s", np.float64, (None,))
        read_only(self, "world_from_agent", np.float64, (len(self.time_s), 4, 4))
        if len(self.time_s) < 1 or np.any(np.diff(self.time_s) <= 0):
            raise ValueError("times of a trajectory must rise from key to key")

    @cached_property
    def _slerp(self) -> Slerp:
        from scipy.spatial.transform import Rotation, Slerp  # late: checking a recipe interpolates nothing

        return Slerp(self.time_s, Rotation.from_matrix(self.world_from_agent[:, :3, :3]))

    @cached_property
    def continued(self) -> Trajectory:
        """The way with a tenth of a second more at either end, in the motion of its first and its last step.

        For what happens within an exposure at the ends: an agent does not stand still before its first frame.
        """
        if len(self.time_s) == 1:
            return self
        before, after = self._beyond(0, 1), self._beyond(-1, -2)
        return Trajectory(
            np.concatenate([[self.time_s[0] - _BEYOND_S], self.time_s, [self.time_s[-1] + _BEYOND_S]]),
            np.concatenate([before[None], self.world_from_agent, after[None]]),
        )

    def _beyond(self, end: int, inner: int) -> NDArray[np.float64]:
        """(4, 4) the pose `_BEYOND_S` beyond an end, by the motion from the key before it [m]."""
        from scipy.spatial.transform import Rotation  # late, as above

        last, first = self.world_from_agent[end], self.world_from_agent[inner]
        steps = _BEYOND_S / abs(self.time_s[end] - self.time_s[inner])
        turn = Rotation.from_matrix(last[:3, :3] @ first[:3, :3].T).as_rotvec()
        pose = np.eye(4)
        pose[:3, :3] = Rotation.from_rotvec(turn * steps).as_matrix() @ last[:3, :3]
        pose[:3, 3] = last[:3, 3] + steps * (last[:3, 3] - first[:3, 3])
        return pose

    def at(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 4, 4) poses at the (N,) times, held constant beyond the ends [m]."""
        time_s = np.clip(np.asarray(time_s, dtype=np.float64), self.time_s[0], self.time_s[-1])
        poses = np.tile(np.eye(4), (len(time_s), 1, 1))
        if len(self.time_s) == 1:
            poses[:] = self.world_from_agent[0]
            return poses
        poses[:, :3, :3] = self._slerp(time_s).as_matrix()
        for axis in range(3):
            poses[:, axis, 3] = np.interp(time_s, self.time_s, self.world_from_agent[:, axis, 3])
        return poses


@dataclass(frozen=True)
class Crossing:
    """The agent steps on an object (a threshold) at a time [s]."""

    object_id: int
    time_s: float
    """When [s]."""
    walk: int | None = None
    """The walk it belongs to, whether or not a frame follows it; None where that is the walk whose frames lie
    around it.
    """


@dataclass(frozen=True, eq=False)
class Mover:
    """A thing of the world on its own way."""

    object_id: int
    """An object of the world that `moves`."""
    trajectory: Trajectory
    """Rigid transforms that take the object from where it rests in the world to where it is [m]."""


@dataclass(frozen=True, eq=False)
class Episode:
    """Frames to take in a world, or a run of consecutive ones: ``episode[8:16]`` is a batch."""

    world: World
    """The world; shared by all batches."""
    trajectory: Trajectory
    time_s: NDArray[np.float64]
    """(N,) middle of each frame's exposure [s]."""
    walk: NDArray[np.int32]
    """(N,) int32: frames with equal numbers belong to one continuous walk; between walks the agent jumps."""
    crossings: tuple[Crossing, ...] = ()
    """Every step on an obstacle that counts in the whole episode."""
    movers: tuple[Mover, ...] = ()
    """The things that move while the agent does; everything else stands still."""
    first_frame: int = 0
    """Index of frame 0 of this batch in the whole episode."""
    absent: tuple[str, ...] = ()
    """The truth that nobody knows of it, by the names in `TRUTHS`; what needs it is refused."""

    def __post_init__(self) -> None:
        read_only(self, "time_s", np.float64, (None,))
        read_only(self, "walk", np.int32, (len(self.time_s),))
        for mover in self.movers:
            if not self.world.objects[mover.object_id].moves:
                raise ValueError(f"object {mover.object_id} of the world is not one that moves")

    def __len__(self) -> int:
        return len(self.time_s)

    def __getitem__(self, frames: slice) -> Episode:
        start, _, step = frames.indices(len(self))
        if step != 1:
            raise ValueError("a batch is a run of consecutive frames: episode[start:stop]")
        return replace(
            self, time_s=self.time_s[frames], walk=self.walk[frames], first_frame=self.first_frame + start
        )
