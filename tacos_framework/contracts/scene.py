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
    """Carrier of the cameras through the world, in a word: ``person``, ``car``, ... Reports draw it."""

    moves: str = ""
    """Motion of the cameras through its world, as in "1 m/s, shaken as on a head". Reports say it."""

    one_world: ClassVar[bool] = False
    """True if every episode is a trip through the same world, so that unseen scenes are other trips only."""

    remarks: tuple[str, ...] = ()
    """Doubts about the files of its world, and statements in them that are not carried out. May open them."""

    absent: tuple[str, ...] = ()
    """The truth that it does not know, by the names in `TRUTHS`. Tasks that need it are refused."""

    not_shown: Callable[..., Mapping[str, str]] | None = None
    """``not_shown(rig, *, exposure, sensors, illumination_lux)``: why its light is not that of these
    cameras, as that of a recording is no finer than its pixels: a word or two -> a sentence. Such a candidate
    fails before anything is rendered, and ``--check`` says how much of the design space is left."""


@runtime_checkable
class EpisodeStore(Protocol):
    """Keeps episodes beyond a simulation, so that each is made once; see the hook
    `tacos_episode_stores`."""

    def episode(
        self, scene: type[Any], config: Settings, follows_from: Mapping[str, Any], make: Callable[[], Episode]
    ) -> Episode:
        """The episode of `make`, or one it has made for the same scene class, settings and plain data to
        start from.
        """
        ...
