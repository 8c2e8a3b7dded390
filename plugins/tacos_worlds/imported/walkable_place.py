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
    """A file, ready to be walked in.

    Parameters
    ----------
    world
        Lit as its sources are.
    lux
        Mean illuminance 1 m above the floor in that world [lux].
    obstacles
        Ids of objects that count when stepped on.
    recorded
        Poses of the agent from a file, or None.
    """

    world: World
    lux: float
    floor: Floor
    agent: Agent
    occlusion: Occlusion
    object_of_triangle: NDArray[np.int32]
    obstacles: tuple[int, ...]
    recorded: Trajectory | None
