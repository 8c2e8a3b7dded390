"""Worlds, and trips through them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np

from tacos_framework.settings import Settings
from tacos_framework.values import Episode


class Scene(Protocol):
    """Makes worlds and the agent's trips through them.

    `SceneBase` has the optional members.
    """

    Config: ClassVar[type[Settings]]

    def episode(self, *, rng: np.random.Generator, illumination_lux: float) -> Episode:
        """One trip; the same generator state gives the same episode, always.

        Illuminance is the mean on a horizontal plane 1 m above the floor (or ground) [lux].
        """
        ...


class SceneBase:
    """Optional members of a `Scene`, with their defaults."""

    carrier: ClassVar[str] = ""
    """What carries the cameras through the world, in a word: ``person``, ``car``, ... Reports draw it."""

    one_world: ClassVar[bool] = False
    """Whether every episode is a trip through the same world, so that unseen scenes are other trips only."""

    remarks: tuple[str, ...] = ()
    """Doubts about the files of its world, and statements in them that are not carried out. May open them."""


@runtime_checkable
class EpisodeStore(Protocol):
    """Keeps episodes beyond a simulation, so that each is made once; see the hook
    `tacos_episode_stores`."""

    def episode(
        self, scene: type[Any], config: Settings, follows_from: Mapping[str, Any], make: Callable[[], Episode]
    ) -> Episode:
        """What `make` gives, or has given for the same scene class, settings and plain data to start from."""
        ...
