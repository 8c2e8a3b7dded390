"""A file that was read, lit and found to have a floor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Trajectory, World
from tacos_plugins.lighting.occlusion import Occlusion
from tacos_worlds.imported.floor import Agent, Floor


@dataclass(frozen=True, eq=False)
class Place:
    """A file, ready to be walked in."""

    world: World  # lit as its sources are
    lux: float  # mean illuminance 1 m above the floor in that world [lux]
    floor: Floor
    agent: Agent
    occlusion: Occlusion
    object_of_triangle: NDArray[np.int32]
    obstacles: tuple[int, ...]  # ids of objects that count when stepped on
    recorded: Trajectory | None  # poses of the agent from a file, or None
